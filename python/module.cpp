// The Python module scanknit._core: a volume, its mesh, and recordings. No call that takes long holds the interpreter.
#include <pybind11/pybind11.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <utility>
#include <variant>

#include "acquire/filter/depth_filter.h"
#include "acquire/frame_source.h"
#include "core/version.h"
#include "export/mesh/write_mesh.h"
#include "extract/extract_surface.h"
#include "fusion/integrate/integrate.h"
#include "fusion/volume/tsdf_volume.h"
#include "python/arrays.h"
#include "python/errors.h"
#include "python/scan.h"

namespace py = pybind11;

namespace scanknit {
namespace {

constexpr std::pair<const char*, UpAxis> kAxes[] = {{"x", UpAxis::kX},       {"y", UpAxis::kY},
                                                    {"z", UpAxis::kZ},       {"-x", UpAxis::kMinusX},
                                                    {"-y", UpAxis::kMinusY}, {"-z", UpAxis::kMinusZ}};

UpAxis axis_named(const std::string& name) {
  for (const auto& [word, axis] : kAxes) {
    if (name == word) return axis;
  }
  throw py::value_error("up: expected one of x, y, z, -x, -y, -z, got '" + name + "'");
}

std::string name_of(UpAxis axis) {
  for (const auto& [word, named] : kAxes) {
    if (axis == named) return word;
  }
  return "-y";
}

/// `rows` x 3 values, which stay the owner's and cannot be changed.
template <typename Scalar>
py::array_t<Scalar> rows_of_three(const void* values, std::size_t rows, const py::object& owner) {
  const auto count = static_cast<py::ssize_t>(rows);
  py::array_t<Scalar> array({count, py::ssize_t{3}}, static_cast<const Scalar*>(values), owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// As `scanknit.Mesh`.
class PythonMesh {
 public:
  explicit PythonMesh(Mesh mesh) : mesh_(std::move(mesh)) {}

  [[nodiscard]] const Mesh& mesh() const { return mesh_; }

  void write(const std::filesystem::path& path, const std::string& up) const {
    const UpAxis axis = axis_named(up);
    const py::gil_scoped_release others_run;
    (void)value_or_throw(write_mesh(mesh_, path, {}, axis));
  }

 private:
  Mesh mesh_;
};

/// As `scanknit.Volume`. One call at a time works on it.
class PythonVolume {
 public:
  explicit PythonVolume(const FusionConfig& config) : volume_(value_or_throw(TsdfVolume::create(config))) {}

  void integrate_frame(Frame& frame, const Pose& T_world_camera, const AcquireConfig& filters) {
    const py::gil_scoped_release others_run;
    const std::scoped_lock alone(mutex_);
    succeed_or_throw(filter_frame(frame, filters, volume_.config().noise));
    (void)value_or_throw(integrate(frame, T_world_camera, volume_));
  }

  [[nodiscard]] std::unique_ptr<PythonMesh> extract(double isovalue, std::size_t min_component_triangles) {
    const py::gil_scoped_release others_run;
    const std::scoped_lock alone(mutex_);
    ExtractConfig config;
    config.isovalue = isovalue;
    config.min_component_triangles = min_component_triangles;
    succeed_or_throw(check_extract_config(config));
    return std::make_unique<PythonMesh>(value_or_throw(extract_surface(volume_.field_view(), config)).mesh);
  }

  void save(const std::filesystem::path& path) {
    const py::gil_scoped_release others_run;
    const std::scoped_lock alone(mutex_);
    succeed_or_throw(volume_.save(path));
  }

  [[nodiscard]] const FusionConfig& config() const { return volume_.config(); }
  [[nodiscard]] std::uint32_t frames() const { return volume_.frames; }
  [[nodiscard]] std::size_t active_voxels() const { return volume_.active_voxels(); }
  [[nodiscard]] bool is_budget_reached() const { return volume_.is_budget_reached; }

 private:
  TsdfVolume volume_;
  std::mutex mutex_;
};

/// As `scanknit.Recording`: an iterator of frames.
class PythonRecording {
 public:
  PythonRecording(const std::filesystem::path& path) {
    const py::gil_scoped_release others_run;
    source_ = value_or_throw(open_recording(path, {}));
  }

  [[nodiscard]] const RecordingInfo& info() const { return source_->info(); }
  [[nodiscard]] std::size_t dropped() const { return dropped_; }

  /// The next frame that can be used; those before it are counted.
  [[nodiscard]] std::unique_ptr<Frame> next() {
    const py::gil_scoped_release others_run;
    const std::scoped_lock alone(mutex_);
    for (;;) {
      FrameEvent event = source_->next({});
      if (auto* frame = std::get_if<Frame>(&event)) return std::make_unique<Frame>(std::move(*frame));
      if (const auto* error = std::get_if<Error>(&event)) throw Failure(*error);
      if (std::holds_alternative<EndOfStream>(event)) throw py::stop_iteration();
      ++dropped_;
    }
  }

 private:
  std::unique_ptr<FrameSource> source_;
  std::mutex mutex_;
  std::size_t dropped_ = 0;
};

std::unique_ptr<PythonVolume> make_volume(double voxel_size, double truncation, double truncation_sigmas,
                                          double max_weight, bool carve_free_space, std::size_t memory_budget_mib) {
  FusionConfig config;
  config.voxel_size_m = voxel_size;
  config.truncation_voxels = truncation;
  config.truncation_sigmas = truncation_sigmas;
  config.max_weight = max_weight;
  config.carve_free_space = carve_free_space;
  config.memory_budget_mib = memory_budget_mib;
  return std::make_unique<PythonVolume>(config);
}

/// A NumPy array, or a TypeError.
py::array array_of(const py::object& given, const char* name) {
  if (!py::isinstance<py::array>(given)) throw py::type_error(std::string(name) + ": expected a NumPy array");
  return given;
}

void integrate_arrays(PythonVolume& volume, const py::object& depth, const py::object& intrinsics,
                      const py::object& pose, const py::object& colour, const py::object& colour_intrinsics,
                      const py::object& colour_pose, double depth_scale, double edge_sigmas) {
  Frame frame;
  frame.depth_m = depth_image(array_of(depth, "depth"), depth_scale);
  const int width = frame.depth_m.width();
  const int height = frame.depth_m.height();
  frame.intrinsics = intrinsics_of(intrinsics, width, height, "intrinsics");
  const Pose T_world_camera = pose_of(pose, "pose");
  if (!colour.is_none()) {
    ColourFrame seen;
    seen.image = colour_image(array_of(colour, "colour"));
    const bool is_same_size = seen.image.width() == width && seen.image.height() == height;
    if (colour_intrinsics.is_none() && !is_same_size) {
      throw py::value_error("colour_intrinsics: needed where colour is not of the size of depth");
    }
    seen.intrinsics = colour_intrinsics.is_none() ? frame.intrinsics
                                                  : intrinsics_of(colour_intrinsics, seen.image.width(),
                                                                  seen.image.height(), "colour_intrinsics");
    if (!colour_pose.is_none()) seen.T_colour_depth = pose_of(colour_pose, "colour_pose");
    frame.colour = std::move(seen);
  }
  AcquireConfig filters;
  filters.edge_sigmas = edge_sigmas;
  volume.integrate_frame(frame, T_world_camera, filters);
}

/// A property of PythonMesh: a list of three numbers each, as an array.
template <typename Scalar, typename List>
auto rows_of(List Mesh::*member) {
  return [member](const py::object& self) {
    const List& list = self.cast<PythonMesh&>().mesh().*member;
    return rows_of_three<Scalar>(list.data(), list.size(), self);
  };
}

void add_mesh(py::module_& module) {
  py::class_<PythonMesh>(module, "Mesh",
                         "A triangle mesh in the world's frame, metres. Its arrays cannot be written to.")
      .def_property_readonly("vertices", rows_of<float>(&Mesh::positions_m), "(N, 3) float32, metres.")
      .def_property_readonly("triangles", rows_of<std::uint32_t>(&Mesh::triangles),
                             "(M, 3) uint32, indices of vertices, counter-clockwise seen from outside.")
      .def_property_readonly("normals", rows_of<float>(&Mesh::normals), "(N, 3) float32, unit length, outwards.")
      .def_property_readonly("colours", rows_of<std::uint8_t>(&Mesh::colours),
                             "(N, 3) uint8, sRGB; grey (128) where no colour was seen.")
      .def("write", &PythonMesh::write, py::arg("path"), py::arg("up") = "-y",
           "Writes .glb, .ply, .obj, .stl, .3mf or .tiles, whole or not at all. `up`: the world's axis that points "
           "up, by which GLB, STL and tiles are turned upright.");
}

void add_volume(py::module_& module) {
  const FusionConfig defaults;
  py::class_<PythonVolume>(module, "Volume",
                           "A truncated signed distance volume that grows with the frames it is given.")
      .def(py::init(&make_volume), py::arg("voxel_size") = defaults.voxel_size_m, py::kw_only(),
           py::arg("truncation") = defaults.truncation_voxels,
           py::arg("truncation_sigmas") = defaults.truncation_sigmas, py::arg("max_weight") = defaults.max_weight,
           py::arg("carve_free_space") = defaults.carve_free_space,
           py::arg("memory_budget_mib") = defaults.memory_budget_mib,
           "voxel_size: metres. truncation: half-width of the band, voxels; at least truncation_sigmas standard "
           "deviations of the depth noise.")
      .def("integrate", &integrate_arrays, py::arg("depth"), py::arg("intrinsics"), py::arg("pose"),
           py::arg("colour") = py::none(), py::kw_only(), py::arg("colour_intrinsics") = py::none(),
           py::arg("colour_pose") = py::none(), py::arg("depth_scale") = 1000.0,
           py::arg("edge_sigmas") = AcquireConfig{}.edge_sigmas,
           "Fuses one frame.\n\n"
           "depth: (H, W) float32, metres along the optical axis, or uint16 with depth_scale units a metre; what is "
           "not\n"
           "finite and above 0 is no return. intrinsics: (fx, fy, cx, cy) or 3 x 3, pixels; pixel centres are "
           "integers.\n"
           "pose: (4, 4), camera to world, metres; x right, y down, z forward. colour: (h, w, 3) uint8, sRGB.\n"
           "colour_intrinsics: needed where colour has another size. colour_pose: (4, 4), depth camera to colour "
           "camera.\n"
           "edge_sigmas: depth beside a step of more standard deviations is left out; 0 keeps it.")
      .def("extract", &PythonVolume::extract, py::arg("isovalue") = 0.0, py::kw_only(),
           py::arg("min_component_triangles") = 0,
           "The surface where the signed distance is `isovalue`, metres, as a Mesh. Smaller pieces than\n"
           "min_component_triangles are left out.")
      .def("save", &PythonVolume::save, py::arg("path"), "Writes the volume as .vdb (OpenVDB).")
      .def_property_readonly(
          "voxel_size", [](const PythonVolume& volume) { return volume.config().voxel_size_m; }, "Metres.")
      .def_property_readonly("frames", &PythonVolume::frames, "How many were fused.")
      .def_property_readonly("active_voxels", &PythonVolume::active_voxels, "Voxels that were observed.")
      .def_property_readonly("is_budget_reached", &PythonVolume::is_budget_reached,
                             "The volume has reached memory_budget_mib and grows no further.");
}

py::object optional_pose(const std::optional<Pose>& pose) {
  return pose ? py::object(matrix_of(*pose)) : py::none();
}

void add_frame(py::module_& module) {
  py::class_<Frame>(module, "Frame", "What a scanner saw at one moment.")
      .def_property_readonly(
          "depth",
          [](const py::object& self) {
            const DepthImage& depth_m = self.cast<Frame&>().depth_m;
            py::array_t<float> array({depth_m.height(), depth_m.width()}, depth_m.pixels().data(), self);
            array.attr("setflags")(py::arg("write") = false);
            return array;
          },
          "(H, W) float32, metres; 0: no return.")
      .def_property_readonly(
          "intrinsics", [](const Frame& frame) { return tuple_of(frame.intrinsics); },
          "fx, fy, cx, cy of depth, pixels.")
      .def_property_readonly(
          "pose", [](const Frame& frame) { return optional_pose(frame.T_world_camera); },
          "(4, 4), camera to world, metres; None where the recording has none.")
      .def_property_readonly(
          "colour",
          [](const py::object& self) -> py::object {
            const auto& colour = self.cast<Frame&>().colour;
            if (!colour) return py::none();
            const ColourImage& image = colour->image;
            const auto* bytes = static_cast<const std::uint8_t*>(static_cast<const void*>(image.pixels().data()));
            py::array_t<std::uint8_t> array({image.height(), image.width(), 3}, bytes, self);
            array.attr("setflags")(py::arg("write") = false);
            return array;
          },
          "(h, w, 3) uint8, sRGB, or None.")
      .def_property_readonly(
          "colour_intrinsics",
          [](const Frame& frame) -> py::object {
            if (!frame.colour) return py::none();
            return tuple_of(frame.colour->intrinsics);
          },
          "fx, fy, cx, cy of colour, or None.")
      .def_property_readonly(
          "colour_pose",
          [](const Frame& frame) -> py::object {
            if (!frame.colour) return py::none();
            return matrix_of(frame.colour->T_colour_depth);
          },
          "(4, 4), depth camera to colour camera, or None.")
      .def_readonly("number", &Frame::sequence, "Its place in the recording, or the recording's own number.");
}

void add_recording(py::module_& module) {
  py::class_<PythonRecording>(
      module, "Recording",
      "A recording in any layout that `scanknit run` reads, as an iterator of frames. Frames that "
      "cannot be used are passed over and counted.")
      .def(py::init<const std::filesystem::path&>(), py::arg("path"))
      .def("__iter__", [](const py::object& self) { return self; })
      .def("__next__", &PythonRecording::next)
      .def("__len__", [](const PythonRecording& recording) { return recording.info().frames; })
      .def_property_readonly("format", [](const PythonRecording& recording) { return recording.info().format; })
      .def_property_readonly(
          "up", [](const PythonRecording& recording) { return name_of(recording.info().world_up); },
          "The axis of its world that points up, for Mesh.write().")
      .def_property_readonly("dropped", &PythonRecording::dropped, "Frames that could not be used, so far.");
}

}  // namespace
}  // namespace scanknit

PYBIND11_MODULE(_core, module) {
  module.attr("__version__") = scanknit::kVersion;
  scanknit::add_errors(module);
  scanknit::add_mesh(module);
  scanknit::add_volume(module);
  scanknit::add_frame(module);
  scanknit::add_recording(module);
  scanknit::add_scan(module);
}

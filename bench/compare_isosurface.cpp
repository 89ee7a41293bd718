// How fast volumes become meshes, against Debian's VTK (flying edges) and OpenVDB (volumeToMesh), all in one run: dense
// float input, normals off, the making of the grid that OpenVDB needs not counted, the best of several rounds that take
// turns. `compare_isosurface [threads] [rounds]`, threads for us and OpenVDB; flying edges is given one.
#include <fmt/format.h>
#include <malloc.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "bench/noise_volume.h"
#include "extract/extract_surface.h"

namespace scanknit {
namespace {

struct VdbMesh {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
};

struct Measure {
  double seconds = std::numeric_limits<double>::infinity();
  std::size_t triangles = 0;
  void add(double s, std::size_t t) {
    seconds = std::min(seconds, s);
    triangles = t;
  }
};

/// `work` gives its mesh, which is given back to the system after the clock has stopped; `count` its triangles.
template <typename Work, typename Count>
void time(Measure& measure, const Work& work, const Count& count) {
  {
    const auto start = std::chrono::steady_clock::now();
    const auto mesh = work();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    measure.add(seconds, count(mesh));
  }
  malloc_trim(0);
}

void compare(const char* name, const BenchVolume& volume, int rounds) {
  ExtractConfig config;
  config.normals = false;
  const DenseView view{volume.samples.data(), Eigen::Vector3i::Constant(volume.side), Eigen::Affine3d::Identity()};

  vtkNew<vtkImageData> image;
  image->SetDimensions(volume.side, volume.side, volume.side);
  image->AllocateScalars(VTK_FLOAT, 1);
  std::copy(volume.samples.begin(), volume.samples.end(), static_cast<float*>(image->GetScalarPointer()));

  openvdb::tools::Dense<const float, openvdb::tools::LayoutXYZ> dense(
      openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(volume.side - 1)), volume.samples.data());
  const auto grid = openvdb::FloatGrid::create(-1);
  openvdb::tools::copyFromDense(dense, *grid, 0);

  Measure ours, vtk, vdb;
  for (int round = 0; round < rounds; ++round) {
    time(
        ours, [&] { return extract_surface(view, config); },
        [](const auto& surface) { return surface->mesh.triangles.size(); });
    time(
        vtk,
        [&] {
          vtkNew<vtkFlyingEdges3D> filter;
          filter->SetInputData(image);
          filter->SetValue(0, 0);
          filter->ComputeNormalsOff();
          filter->ComputeScalarsOff();
          filter->Update();
          return vtkSmartPointer<vtkPolyData>(filter->GetOutput());
        },
        [](const auto& mesh) { return static_cast<std::size_t>(mesh->GetNumberOfPolys()); });
    time(
        vdb,
        [&] {
          VdbMesh mesh;
          openvdb::tools::volumeToMesh(*grid, mesh.points, mesh.triangles, mesh.quads, 0.0);
          return mesh;
        },
        [](const VdbMesh& mesh) { return mesh.triangles.size() + 2 * mesh.quads.size(); });
  }
  const double cells = std::pow(volume.side - 1, 3);
  const auto print = [&](const char* code, const Measure& measure) {
    fmt::print("{:13} {:4}^3  {:12} {:8.1f} ms {:9.1f} Mcell/s {:7.1f} Mtri/s {:10} triangles {:6.2f} x\n", name,
               volume.side, code, 1e3 * measure.seconds, 1e-6 * cells / measure.seconds,
               1e-6 * static_cast<double>(measure.triangles) / measure.seconds, measure.triangles,
               vtk.seconds / measure.seconds);
  };
  print("ScanKnit", ours);
  print("flying edges", vtk);
  print("OpenVDB", vdb);
}

}  // namespace
}  // namespace scanknit

/// `compare_isosurface [threads] [rounds] [volume]`: all three volumes, or one of sphere, smooth, white.
int main(int argc, char** argv) {
  const std::string only = argc > 3 ? argv[3] : "";
  const int threads = argc > 1 ? std::atoi(argv[1]) : 1;
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 5;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  setenv("VTK_SMP_BACKEND_IN_USE", "Sequential", 1);  // its header does not compile as C++20
  openvdb::initialize();
  fmt::print("{} thread(s), best of {}; the last column is the speed relative to flying edges\n", threads, rounds);
  const auto is_wanted = [&](const char* name) { return only.empty() || only == name; };
  if (is_wanted("sphere")) scanknit::compare("sphere", scanknit::sphere(256), rounds);
  if (is_wanted("smooth")) scanknit::compare("smooth noise", scanknit::smooth_noise(256, 1), rounds);
  if (is_wanted("white")) scanknit::compare("white noise", scanknit::white_noise(128, 1), rounds);
  return 0;
}

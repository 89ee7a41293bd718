// How fast volumes become meshes, and how much memory that takes beside the volume, against Debian's VTK (flying edges)
// and OpenVDB (volumeToMesh), all in one run: dense float input, normals off, the making of the grid that OpenVDB needs
// not counted, the best of several rounds that take turns. Threads are for us and OpenVDB; flying edges is given one.
#include <fmt/format.h>
#include <malloc.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
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

Result<Surface> scanknit_mesh(const BenchVolume& volume) {
  ExtractConfig config;
  config.normals = false;
  return extract_surface(
      DenseView{volume.samples.data(), Eigen::Vector3i::Constant(volume.side), Eigen::Affine3d::Identity()}, config);
}

vtkNew<vtkImageData> vtk_image(const BenchVolume& volume) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(volume.side, volume.side, volume.side);
  image->AllocateScalars(VTK_FLOAT, 1);
  std::copy(volume.samples.begin(), volume.samples.end(), static_cast<float*>(image->GetScalarPointer()));
  return image;
}

vtkSmartPointer<vtkPolyData> vtk_mesh(vtkImageData* image) {
  vtkNew<vtkFlyingEdges3D> filter;
  filter->SetInputData(image);
  filter->SetValue(0, 0);
  filter->ComputeNormalsOff();
  filter->ComputeScalarsOff();
  filter->Update();
  return filter->GetOutput();
}

/// A figure of this process in /proc, KiB.
std::size_t process_memory(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (std::size_t kib = 0; word == key + ":" && status >> kib) return kib;
  }
  return 0;
}

/// The most memory that `work` takes beyond what there was, its mesh included, MiB; in a process of its own, for which
/// no thread may run yet.
template <typename Work>
double memory_of(const Work& work) {
  std::array<int, 2> channel{};
  if (pipe(channel.data()) != 0) return 0;
  std::size_t kib = 0;
  if (const pid_t child = fork(); child == 0) {
    const std::size_t before = process_memory("VmRSS");
    const auto mesh = work();
    kib = process_memory("VmHWM") - before;
    _exit(write(channel[1], &kib, sizeof kib) == sizeof kib ? 0 : 1);
  } else {
    if (read(channel[0], &kib, sizeof kib) != sizeof kib) kib = 0;
    waitpid(child, nullptr, 0);
  }
  close(channel[0]);
  close(channel[1]);
  return static_cast<double>(kib) / 1024;
}

void compare_memory(const char* name, const BenchVolume& volume) {
  const auto image = vtk_image(volume);
  const double ours = memory_of([&] { return scanknit_mesh(volume); });
  const double vtk = memory_of([&] { return vtk_mesh(image); });
  fmt::print("{:13} {:4}^3  memory beside the volume: ScanKnit {:.1f} MiB, flying edges {:.1f} MiB, {:.2f} x\n", name,
             volume.side, ours, vtk, ours / vtk);
}

void compare_time(const char* name, const BenchVolume& volume, int rounds) {
  const auto image = vtk_image(volume);
  openvdb::tools::Dense<const float, openvdb::tools::LayoutXYZ> dense(
      openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(volume.side - 1)), volume.samples.data());
  const auto grid = openvdb::FloatGrid::create(-1);
  openvdb::tools::copyFromDense(dense, *grid, 0);

  Measure ours, vtk, vdb;
  for (int round = 0; round < rounds; ++round) {
    time(
        ours, [&] { return scanknit_mesh(volume); },
        [](const auto& surface) { return surface->mesh.triangles.size(); });
    time(
        vtk, [&] { return vtk_mesh(image); },
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
  using namespace scanknit;
  const auto each = [&](const auto& compare) {
    if (is_wanted("sphere")) compare("sphere", sphere(256));
    if (is_wanted("smooth")) compare("smooth noise", smooth_noise(256, 1));
    if (is_wanted("white")) compare("white noise", white_noise(128, 1));
  };
  each(&compare_memory);
  each([&](const char* name, const BenchVolume& volume) { compare_time(name, volume, rounds); });
  return 0;
}

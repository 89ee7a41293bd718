// Other programs that read our files, and what they say of them.
#pragma once

#include <filesystem>
#include <string>

#include "export/export_config.h"
#include "export/texture/mesh_texture.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/texture_samples.h"
#include "tests/readers/reader_sample.h"

namespace scanknit::test {

[[nodiscard]] bool has_command(const std::string& name);

/// What a command said, its errors too, and its exit code.
struct Said {
  int exit_code = 0;
  std::string text;
};
[[nodiscard]] Said run(const std::string& command);

/// Debian's Python, whatever comes first in PATH: its modules are what is asked for.
[[nodiscard]] std::string debian_python();

/// {"vertices": [[x, y, z] ...], "colours": [[r, g, b] ...] with 1 for white, "triangles": [[a, b, c] ...]}
[[nodiscard]] ToldMesh told_in_json(const std::filesystem::path& json_file);

/// A mesh in a file of a test's own.
class WrittenMesh {
 public:
  /// `name`: its extension is the format. The world is a camera's: y points down.
  WrittenMesh(const Mesh& mesh, const std::string& name, const ExportConfig& config = {},
              const MeshTexture* texture = nullptr);

  [[nodiscard]] std::string path() const { return folder_ / file_; }
  [[nodiscard]] std::string json() const { return folder_ / "told.json"; }

 private:
  TemporaryFolder folder_;
  std::string file_;
};

/// Of a GLB in several primitives: what each reader is to see, and how many vertices they have together.
[[nodiscard]] ExportConfig in_primitives();
[[nodiscard]] std::size_t vertices_in_primitives(const Mesh& mesh);

/// A GLB whose colours are in a texture, one texel a vertex.
class TexturedFile {
 public:
  explicit TexturedFile(const Mesh& mesh, const ExportConfig& config = {});

  [[nodiscard]] const WrittenMesh& file() const { return file_; }
  [[nodiscard]] const ColourImage& image() const { return texels_.image; }
  [[nodiscard]] const std::vector<std::uint8_t>& picture_file() const { return texels_.texture.image; }

 private:
  OwnTexels texels_;
  WrittenMesh file_;
};

// Rotations from the recording's world (x right, y down, z away), by their rows.
[[nodiscard]] Eigen::Matrix3d as_it_is();
[[nodiscard]] Eigen::Matrix3d y_up();  ///< GLB: (x, -y, -z)
[[nodiscard]] Eigen::Matrix3d z_up();  ///< STL, 3MF: (x, z, -y)

}  // namespace scanknit::test

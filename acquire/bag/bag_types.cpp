// Whether a bag of ROS may have messages of a type, by what it says of itself.
#include <algorithm>
#include <optional>

#include "acquire/bag/bag_messages.h"
#include "acquire/bag/bag_metadata.h"
#include "acquire/mcap/mcap_summary.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOurProfile = "x-scanknit";  // McapWriter's

/// By the index at the file's end; nothing: it has none.
std::optional<bool> has_type(std::unique_ptr<RandomAccess> file, const std::string& type, const Limits& limits) {
  if (is_mcap(*file)) {
    if (mcap_profile(*file) == kOurProfile) return false;  // also where it is torn
    const auto summary = read_mcap_summary(*file);
    if (!summary || summary->schemas.empty()) return std::nullopt;  // writers need not repeat them there
    return std::any_of(summary->schemas.begin(), summary->schemas.end(),
                       [&](const McapSchema& schema) { return without_msg(schema.name) == type; });
  }
  if (!is_ros_bag(*file)) return std::nullopt;
  const auto connections = RosBag::indexed_connections(std::move(file), limits);
  if (!connections) return std::nullopt;
  return std::any_of(connections->begin(), connections->end(),
                     [&](const BagConnection& connection) { return connection.type == type; });
}

/// By metadata.yaml, which lists the types of the topics; nothing: it is not there, or not of this file.
std::optional<bool> metadata_has_type(const fs::path& folder, const fs::path& file, const std::string& type,
                                      const Limits& limits) {
  const auto yaml = read_text_file(folder / "metadata.yaml", limits.max_text_bytes);
  if (!yaml || !is_bag_metadata(*yaml)) return std::nullopt;
  if (!file.empty()) {
    const auto files = files_of_bag(*yaml);
    const auto is_it = [&](const std::string& name) { return fs::path(name).filename() == file.filename(); };
    if (std::none_of(files.begin(), files.end(), is_it)) return std::nullopt;
  }
  const std::string name = type.substr(type.rfind('/') + 1);
  return yaml->find("/" + name) != std::string::npos;
}

}  // namespace

bool may_have_type(const fs::path& path, const std::string& type, const Limits& limits) {
  std::error_code code;
  if (fs::is_directory(path, code)) return metadata_has_type(path, {}, type, limits).value_or(true);
  auto file = open_random_access(path);
  const auto has = file ? has_type(*std::move(file), type, limits) : std::nullopt;
  if (has) return *has;
  return metadata_has_type(path.parent_path(), path, type, limits).value_or(true);
}

}  // namespace scanknit

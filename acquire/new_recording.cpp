#include "acquire/new_recording.h"

#include <string>
#include <system_error>

namespace scanknit {

Result<void> check_is_new_recording(const std::filesystem::path& path, std::string_view remedy) {
  std::error_code ignored;
  if (!std::filesystem::exists(std::filesystem::symlink_status(path, ignored))) return {};
  return Error{ErrorCode::kOutput, "is there already, and a recording is not overwritten; " + std::string(remedy),
               path.string()};
}

}  // namespace scanknit

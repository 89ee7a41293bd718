#include "core/files/read_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>

namespace scanknit {
namespace {

template <typename Container>
Result<Container> read_whole(const std::filesystem::path& path, std::uintmax_t max_bytes) {
  const auto failure = [&](const std::string& what) { return Error{ErrorCode::kInput, what, path.string()}; };
  std::error_code code;
  const auto status = std::filesystem::status(path, code);
  if (status.type() == std::filesystem::file_type::not_found) return failure("no such file");
  if (code) return failure(code.message());
  if (!std::filesystem::is_regular_file(status)) return failure("not a regular file");
  const std::uintmax_t size = std::filesystem::file_size(path, code);
  if (code) return failure(code.message());
  if (size > max_bytes) {
    return failure(std::to_string(size) + " bytes, more than the limit of " + std::to_string(max_bytes));
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) return failure(std::strerror(errno));
  Container content(static_cast<std::size_t>(size), typename Container::value_type{});
  file.read(reinterpret_cast<char*>(content.data()), static_cast<std::streamsize>(content.size()));
  if (file.gcount() != static_cast<std::streamsize>(content.size())) return failure("could not be read to its end");
  return content;
}

}  // namespace

Result<std::vector<std::byte>> read_file(const std::filesystem::path& path, std::uintmax_t max_bytes) {
  return read_whole<std::vector<std::byte>>(path, max_bytes);
}

Result<std::string> read_text_file(const std::filesystem::path& path, std::uintmax_t max_bytes) {
  return read_whole<std::string>(path, max_bytes);
}

}  // namespace scanknit

// SharedPath: the path of a frame's picture, which all frames of one file share. Private to the room.
#pragma once

#include <filesystem>
#include <memory>
#include <utility>

namespace scanknit {

/// A path that is stored once for all its copies: the 25,000 frames of a bag of 20 GB name one file.
class SharedPath {
 public:
  SharedPath() = default;
  // From and to a path by itself: a frame's path is used like any other.
  SharedPath(std::filesystem::path path) {  // NOLINT(google-explicit-constructor)
    if (!path.empty()) path_ = std::make_shared<const std::filesystem::path>(std::move(path));
  }
  operator const std::filesystem::path&() const { return path(); }  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool empty() const { return path_ == nullptr; }
  const std::filesystem::path* operator->() const { return &path(); }

 private:
  [[nodiscard]] const std::filesystem::path& path() const {
    static const std::filesystem::path kNone;
    return path_ ? *path_ : kNone;
  }

  std::shared_ptr<const std::filesystem::path> path_;
};

}  // namespace scanknit

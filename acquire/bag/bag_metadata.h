// metadata.yaml of a bag of ROS 2 (rosbag2's design document), as far as it says which files the bag has.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace scanknit {

/// True if it is such a file.
[[nodiscard]] bool is_bag_metadata(std::string_view yaml);

/// The names in `relative_file_paths`, in their order, at most 10,000; empty: there are none.
[[nodiscard]] std::vector<std::string> files_of_bag(std::string_view yaml);

}  // namespace scanknit

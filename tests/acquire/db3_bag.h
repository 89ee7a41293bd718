// Bags of ROS 2 in SQLite's files, written by SQLite (write_db3_bag.py).
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include "ros2_bag.h"
#include "test_replay_support.h"

namespace scanknit::test {

/// The file's bytes; nothing: Python or its sqlite3 is not there.
[[nodiscard]] inline std::optional<Bytes> db3_file(const std::vector<Ros2Bag::Logged>& log, int page_size = 4096) {
  const TemporaryFolder folder;
  Bytes messages;
  ByteAppender writer(messages);
  for (const Ros2Bag::Logged& message : log) {
    writer.text(message.topic);
    writer.text(message.type);
    writer.little_endian(message.log_ns);
    writer.little_endian(static_cast<std::uint32_t>(message.data.size()));
    writer.append(message.data);
  }
  write_bytes(folder / "messages", messages);
  const std::string command = "/usr/bin/python3 '" + kSourceDir + "/tests/acquire/write_db3_bag.py' '" +
                              (folder / "messages").string() + "' '" + (folder / "bag.db3").string() + "' " +
                              std::to_string(page_size);
  if (std::system(command.c_str()) != 0) return std::nullopt;  // NOLINT(concurrency-mt-unsafe): one thread
  return bytes_of(folder / "bag.db3");
}

}  // namespace scanknit::test

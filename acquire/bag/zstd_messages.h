// Messages that zstd packed one by one (rosbag2_compression_zstd, "compression_mode: MESSAGE").
#pragma once

#include <memory>

#include "acquire/bag/bag_messages.h"

namespace scanknit {

/// The messages of `packed`, each unpacked where it begins as zstd's frames do, which no plain CDR does.
[[nodiscard]] std::unique_ptr<BagMessages> unpack_messages(std::unique_ptr<BagMessages> packed, const Limits& limits);

}  // namespace scanknit

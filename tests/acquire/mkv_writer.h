// Writes recordings as Azure Kinect's recorder lays them out (Matroska, RFC 9559), for tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/mcap/byte_appender.h"

namespace scanknit::test {

class MkvWriter {
 public:
  using Bytes = std::vector<std::byte>;

  struct Track {
    std::uint64_t number = 0, uid = 0;
    std::string name, fourcc;
    std::uint64_t width = 0, height = 0;
  };

  std::uint64_t scale_ns = 1000;
  bool has_open_sizes = false;     ///< segment and clusters do not say their sizes, as in a live stream
  bool has_simple_blocks = false;  ///< else each block is in a group
  std::uint8_t block_flags = 0;
  std::string doc_type = "matroska";
  std::map<std::string, std::string> tags;
  std::map<std::string, std::string> attached;
  std::vector<Track> tracks;
  Bytes more_of_tracks;  ///< further elements of each track

  /// Begins a cluster.
  void begin_cluster(std::uint64_t time) { clusters_.push_back({time, {}}); }

  void add(std::uint64_t track, std::int16_t later, const Bytes& picture) {
    Bytes block{static_cast<std::byte>(0x80 | track)};
    put(block, static_cast<std::uint16_t>(later), 2);
    put(block, block_flags, 1);
    block.insert(block.end(), picture.begin(), picture.end());
    append(clusters_.back().blocks, has_simple_blocks ? element(0xA3, block) : element(0xA0, element(0xA1, block)));
  }

  [[nodiscard]] Bytes file() const {
    Bytes head;
    append(head, element(0x4286, number(1)));  // version
    append(head, element(0x4282, text(doc_type)));
    Bytes info;
    append(info, element(0x2AD7B1, number(scale_ns)));
    append(info, element(0x7BA9, text("Azure Kinect")));
    Bytes inside = element(0x1549A966, info);
    append(inside, element(0x1654AE6B, all_tracks()));
    append(inside, element(0x1254C367, all_tags()));
    if (!attached.empty()) append(inside, element(0x1941A469, all_attached()));
    append(inside, element(0xEC, Bytes(20)));  // padding
    for (const Cluster& cluster : clusters_) {
      Bytes content = element(0xE7, number(cluster.time));
      append(content, cluster.blocks);
      append(inside, element(0x1F43B675, content, has_open_sizes));
    }
    Bytes bytes = element(0x1A45DFA3, head);
    append(bytes, element(0x18538067, inside, has_open_sizes));
    return bytes;
  }

  static Bytes element(std::uint32_t id, const Bytes& content, bool is_open = false) {
    Bytes bytes;
    const int id_bytes = id > 0xFFFFFF ? 4 : id > 0xFFFF ? 3 : id > 0xFF ? 2 : 1;
    put(bytes, id, id_bytes);
    if (is_open) {
      put(bytes, 0x01FF'FFFF'FFFF'FFFF, 8);
    } else if (content.size() < 0x7F) {
      put(bytes, 0x80 | content.size(), 1);
    } else {
      put(bytes, 0x1000'0000 | content.size(), 4);
    }
    append(bytes, content);
    return bytes;
  }
  static Bytes number(std::uint64_t value) {
    Bytes bytes;
    put(bytes, value, value > 0xFFFF'FFFF ? 8 : value > 0xFFFF ? 4 : value > 0xFF ? 2 : 1);
    return bytes;
  }
  static Bytes text(std::string_view letters) {
    const auto bytes = std::as_bytes(std::span(letters));
    return {bytes.begin(), bytes.end()};
  }
  static void append(Bytes& to, const Bytes& bytes) { to.insert(to.end(), bytes.begin(), bytes.end()); }
  /// Big endian.
  static void put(Bytes& to, std::uint64_t value, int bytes) {
    for (int i = bytes - 1; i >= 0; --i) to.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFF));
  }

 private:
  struct Cluster {
    std::uint64_t time = 0;
    Bytes blocks;
  };

  [[nodiscard]] Bytes all_tracks() const {
    Bytes entries;
    for (const Track& track : tracks) {
      const bool is_video = track.width > 0;
      Bytes entry = element(0xD7, number(track.number));
      append(entry, element(0x73C5, number(track.uid)));
      append(entry, element(0x83, number(is_video ? 1 : 17)));
      append(entry, element(0x536E, text(track.name)));
      append(entry, element(0x23E383, number(33'333'333)));
      append(entry, element(0x86, text(is_video ? "V_MS/VFW/FOURCC" : "S_K4A/IMU")));
      if (is_video) {
        append(entry, element(0x63A2, bitmap_header(track)));
        Bytes video = element(0xB0, number(track.width));
        append(video, element(0xBA, number(track.height)));
        append(entry, element(0xE0, video));
      }
      append(entry, more_of_tracks);
      append(entries, element(0xAE, entry));
    }
    return entries;
  }

  /// BITMAPINFOHEADER, little endian.
  static Bytes bitmap_header(const Track& track) {
    Bytes header;
    ByteAppender out(header);
    out.little_endian(std::uint32_t{40});
    out.little_endian(static_cast<std::uint32_t>(track.width));
    out.little_endian(static_cast<std::uint32_t>(track.height));
    out.little_endian(std::uint16_t{1});
    out.little_endian(std::uint16_t{16});
    append(header, text(track.fourcc));
    header.resize(40);
    return header;
  }

  [[nodiscard]] Bytes all_tags() const {
    Bytes all;
    for (const auto& tag : tags) {
      Bytes simple = element(0x45A3, text(tag.first));
      append(simple, element(0x4487, text(tag.second)));
      Bytes content = element(0x63C0, {});  // of the whole file
      append(content, element(0x67C8, simple));
      append(all, element(0x7373, content));
    }
    return all;
  }

  [[nodiscard]] Bytes all_attached() const {
    Bytes all;
    for (const auto& file : attached) {
      Bytes content = element(0x466E, text(file.first));
      append(content, element(0x4660, text("application/octet-stream")));
      append(content, element(0x465C, text(file.second)));
      append(content, element(0x46AE, number(77)));
      append(all, element(0x61A7, content));
    }
    return all;
  }

  std::vector<Cluster> clusters_;
};

}  // namespace scanknit::test

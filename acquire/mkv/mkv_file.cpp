#include "acquire/mkv/mkv_file.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <utility>

#include "acquire/mkv/ebml_reader.h"
#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

// The ids of elements, by RFC 8794 (EBML) and RFC 9559 (Matroska).
enum : std::uint32_t {
  kEbml = 0x1A45DFA3,
  kDocType = 0x4282,
  kSegment = 0x18538067,
  kSeekHead = 0x114D9B74,
  kInfo = 0x1549A966,
  kTimestampScale = 0x2AD7B1,
  kTitle = 0x7BA9,
  kTracks = 0x1654AE6B,
  kTrackEntry = 0xAE,
  kTrackNumber = 0xD7,
  kTrackUid = 0x73C5,
  kTrackType = 0x83,
  kTrackName = 0x536E,
  kCodecId = 0x86,
  kCodecPrivate = 0x63A2,
  kDefaultDuration = 0x23E383,
  kVideo = 0xE0,
  kPixelWidth = 0xB0,
  kPixelHeight = 0xBA,
  kContentEncodings = 0x6D80,
  kChapters = 0x1043A770,
  kCues = 0x1C53BB6B,
  kTags = 0x1254C367,
  kTag = 0x7373,
  kSimpleTag = 0x67C8,
  kTagName = 0x45A3,
  kTagString = 0x4487,
  kAttachments = 0x1941A469,
  kAttachedFile = 0x61A7,
  kFileName = 0x466E,
  kFileData = 0x465C,
  kCluster = 0x1F43B675,
  kTimestamp = 0xE7,
  kSimpleBlock = 0xA3,
  kBlockGroup = 0xA0,
  kPlainBlock = 0xA1,
};

constexpr std::uint64_t kVideoType = 1;
constexpr std::size_t kMostTracks = 128, kMostTags = 1000, kMostAttached = 16;
constexpr std::uint64_t kTracksOfCamera = 4;  // depth, colour, infrared, and one more
constexpr std::uint64_t kMostAttachedBytes = 1u << 20;
constexpr std::uint64_t kMostPrivateBytes = 1u << 16;
constexpr std::uint64_t kDefaultScale_ns = 1'000'000;
constexpr std::int64_t kMostTime_ns = std::numeric_limits<std::int64_t>::max() / 4;

/// What begins after a cluster, and so ends one whose size is not known.
bool ends_cluster(std::uint32_t id) {
  constexpr std::array kOfSegment = {kSegment, kSeekHead, kInfo,        kTracks,  kChapters,
                                     kCues,    kTags,     kAttachments, kCluster, kEbml};
  for (const std::uint32_t other : kOfSegment) {
    if (id == other) return true;
  }
  return false;
}

/// The four letters of a BITMAPINFOHEADER, which stand at its byte 16.
std::string fourcc_of(std::span<const std::byte> header) {
  constexpr std::size_t kHeaderBytes = 40, kAt = 16;
  std::string letters;
  if (header.size() < kHeaderBytes) return letters;
  for (const std::byte letter : header.subspan(kAt, 4)) letters += std::to_integer<char>(letter);
  return letters;
}

class Survey {
 public:
  Survey(const RandomAccess& file, const Limits& limits)
      : file_(file), most_blocks_(limits.max_frames), steps_(std::uint64_t{limits.max_frames} * 16 + 10'000) {}

  MkvFile take() && {
    EbmlWalk walk(file_, 0, file_.size(), steps_);
    while (const auto element = walk.next()) {
      if (element->id == kSegment) read_segment(*element);
    }
    mkv_.is_torn |= walk.is_damaged();
    return std::move(mkv_);
  }

 private:
  /// Calls `use` with each element in `parent`.
  template <typename Use>
  void each(const EbmlElement& parent, Use use) {
    EbmlWalk walk(file_, parent.content, parent.end, steps_);
    while (const auto element = walk.next()) use(*element);
    mkv_.is_torn |= walk.is_damaged();
  }

  void read_segment(const EbmlElement& segment) {
    EbmlWalk walk(file_, segment.content, segment.end, steps_);
    while (const auto element = walk.next()) {
      switch (element->id) {
        case kInfo: read_info(*element); break;
        case kTracks: read_tracks(*element); break;
        case kTags: read_tags(*element); break;
        case kAttachments: read_attachments(*element); break;
        case kCluster: walk.continue_at(read_cluster(*element)); break;
        default: break;
      }
    }
    mkv_.is_torn |= walk.is_damaged();
  }

  void read_info(const EbmlElement& info) {
    each(info, [&](const EbmlElement& e) {
      if (e.id == kTimestampScale) scale_ns_ = ebml_unsigned(file_, e).value_or(kDefaultScale_ns);
      if (e.id == kTitle) mkv_.title = ebml_text(file_, e).value_or("");
    });
  }

  void read_tracks(const EbmlElement& tracks) {
    each(tracks, [&](const EbmlElement& e) {
      if (e.id == kTrackEntry && mkv_.tracks.size() < kMostTracks) mkv_.tracks.push_back(read_track(e));
    });
  }

  MkvTrack read_track(const EbmlElement& entry) {
    MkvTrack track;
    std::vector<std::byte> header;
    each(entry, [&](const EbmlElement& e) {
      switch (e.id) {
        case kTrackNumber: track.number = ebml_unsigned(file_, e).value_or(0); break;
        case kTrackUid: track.uid = ebml_unsigned(file_, e).value_or(0); break;
        case kTrackType: track.is_video = ebml_unsigned(file_, e) == kVideoType; break;
        case kTrackName: track.name = ebml_text(file_, e).value_or(""); break;
        case kCodecId: track.codec = ebml_text(file_, e).value_or(""); break;
        case kCodecPrivate: header = ebml_bytes(file_, e, kMostPrivateBytes).value_or(std::vector<std::byte>()); break;
        case kDefaultDuration: track.period_ns = ebml_unsigned(file_, e).value_or(0); break;
        case kContentEncodings: track.is_packed = true; break;
        case kVideo: read_size(e, track); break;
        default: break;
      }
    });
    if (track.codec == "V_MS/VFW/FOURCC") track.fourcc = fourcc_of(header);
    return track;
  }

  void read_size(const EbmlElement& video, MkvTrack& track) {
    each(video, [&](const EbmlElement& e) {
      if (e.id == kPixelWidth) track.width = ebml_unsigned(file_, e).value_or(0);
      if (e.id == kPixelHeight) track.height = ebml_unsigned(file_, e).value_or(0);
    });
  }

  void read_tags(const EbmlElement& tags) {
    each(tags, [&](const EbmlElement& tag) {
      if (tag.id != kTag) return;
      each(tag, [&](const EbmlElement& e) {
        if (e.id == kSimpleTag) read_tag(e);
      });
    });
  }

  void read_tag(const EbmlElement& simple) {
    std::string name, value;
    each(simple, [&](const EbmlElement& e) {
      if (e.id == kTagName) name = ebml_text(file_, e).value_or("");
      if (e.id == kTagString) value = ebml_text(file_, e).value_or("");
    });
    if (!name.empty() && mkv_.tags.size() < kMostTags) mkv_.tags.emplace(std::move(name), std::move(value));
  }

  void read_attachments(const EbmlElement& attachments) {
    each(attachments, [&](const EbmlElement& attached) {
      if (attached.id != kAttachedFile || mkv_.attached.size() >= kMostAttached) return;
      std::string name;
      std::optional<std::vector<std::byte>> content;
      each(attached, [&](const EbmlElement& e) {
        if (e.id == kFileName) name = ebml_text(file_, e).value_or("");
        if (e.id == kFileData) content = ebml_bytes(file_, e, kMostAttachedBytes);
      });
      if (content && name.ends_with(".json")) mkv_.attached.emplace(std::move(name), *std::move(content));
    });
  }

  /// Where what comes after it begins.
  std::uint64_t read_cluster(const EbmlElement& cluster) {
    cluster_time_ = 0;
    EbmlWalk walk(file_, cluster.content, cluster.end, steps_);
    while (const auto element = walk.next()) {
      if (cluster.is_open && ends_cluster(element->id)) return element->start;
      switch (element->id) {
        case kTimestamp: cluster_time_ = ebml_unsigned(file_, *element).value_or(0); break;
        case kSimpleBlock: read_block(*element); break;
        case kBlockGroup:
          each(*element, [&](const EbmlElement& e) {
            if (e.id == kPlainBlock) read_block(e);
          });
          break;
        default: break;
      }
    }
    mkv_.is_torn |= walk.is_damaged();
    return cluster.end;
  }

  /// The number of its track, the time from the cluster's on in 16 bits, a byte of flags, then the picture.
  void read_block(const EbmlElement& block) {
    if (block.is_open || block.is_cut_off) return;
    constexpr std::size_t kMostHeadBytes = 8 + 2 + 1;
    std::array<std::byte, kMostHeadBytes> raw{};
    const auto head = std::span(raw).first(static_cast<std::size_t>(std::min<std::uint64_t>(raw.size(), block.size())));
    if (!file_.read(block.content, head)) return;
    const auto track = read_ebml_number(head);
    if (!track) return;
    ByteReader reader(head.subspan(track->length));
    const auto later = reader.big_endian<std::int16_t>();
    const auto flags = reader.big_endian<std::uint8_t>();
    if (!later || !flags) return;
    constexpr std::uint8_t kLacing = 0x06;
    if ((*flags & kLacing) != 0) {
      ++mkv_.laced;
      return;
    }
    const auto time_ns = time_of(*later);
    if (!time_ns || !is_of_video(track->value)) return;
    std::vector<MkvBlock>& blocks = mkv_.blocks[track->value];
    // One more than is allowed of each track, so that the excess is seen; and not of all tracks that a file can claim.
    if (blocks.size() > most_blocks_ || listed_ > kTracksOfCamera * most_blocks_) return;
    ++listed_;
    const std::uint64_t at = block.content + track->length + reader.offset();
    blocks.push_back({*time_ns, at, block.end - at});
  }

  [[nodiscard]] std::optional<std::int64_t> time_of(std::int16_t later) const {
    if (scale_ns_ == 0 || scale_ns_ > 1'000'000'000) return std::nullopt;
    const auto scale_ns = static_cast<std::int64_t>(scale_ns_);
    if (cluster_time_ > static_cast<std::uint64_t>(kMostTime_ns / scale_ns)) return std::nullopt;
    return (static_cast<std::int64_t>(cluster_time_) + later) * scale_ns;
  }

  [[nodiscard]] bool is_of_video(std::uint64_t number) const {
    for (const MkvTrack& track : mkv_.tracks) {
      if (track.number == number) return track.is_video;
    }
    return false;
  }

  const RandomAccess& file_;
  std::size_t most_blocks_;
  std::uint64_t steps_;
  std::uint64_t scale_ns_ = kDefaultScale_ns;
  std::uint64_t cluster_time_ = 0;
  std::uint64_t listed_ = 0;
  MkvFile mkv_;
};

}  // namespace

bool is_matroska(const RandomAccess& file) {
  std::uint64_t steps = 64;  // a head has a handful of elements
  EbmlWalk walk(file, 0, file.size(), steps);
  const auto head = walk.next();
  if (!head || head->id != kEbml || head->is_open || head->is_cut_off) return false;
  EbmlWalk inside(file, head->content, head->end, steps);
  while (const auto element = inside.next()) {
    if (element->id == kDocType) return ebml_text(file, *element) == "matroska";
  }
  return false;
}

MkvFile survey_mkv(const RandomAccess& file, const Limits& limits) {
  return Survey(file, limits).take();
}

}  // namespace scanknit

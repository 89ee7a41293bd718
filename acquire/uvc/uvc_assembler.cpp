#include "acquire/uvc/uvc_assembler.h"

#include <algorithm>
#include <utility>

#include "core/check.h"

namespace scanknit {
namespace {

/// A larger jump of the camera's frame counter is no loss but a counter that began anew.
constexpr std::uint32_t kMaxCounterGap = 10'000;

/// Cuts what follows the end marker (some cameras pad), or says that this is no whole JPEG.
bool trim_to_jpeg(std::vector<std::byte>& bytes) {
  constexpr std::byte kMark{0xFF}, kStart{0xD8}, kEnd{0xD9};
  if (bytes.size() < 4 || bytes[0] != kMark || bytes[1] != kStart) return false;
  std::size_t end = bytes.size();
  while (end > 2 && bytes[end - 1] == std::byte{0}) --end;
  if (bytes[end - 2] != kMark || bytes[end - 1] != kEnd) return false;
  bytes.resize(end);
  return true;
}

UvcAssembler::Loss loss_of(const UnfinishedPicture& picture) {
  return picture.is_too_long ? UvcAssembler::Loss::kOverflow : UvcAssembler::Loss::kTransport;
}

}  // namespace

UvcAssembler::UvcAssembler(const Framing& framing, Deliver deliver) : framing_(framing), deliver_(std::move(deliver)) {
  SCANKNIT_CHECK(framing_.frame_bytes >= 1);
}

void UvcAssembler::add(std::span<const std::byte> bytes, bool ends_payload, std::int64_t host_ns) {
  if (bytes.empty() && !is_in_payload_ && header_size_ == 0) return;
  if (!is_in_payload_) {
    bytes = take_header(bytes);
    if (!is_in_payload_ && !ends_payload) return;  // more of the header is to come
    if (!is_in_payload_) begin_payload();          // it never came
  }
  append(bytes, host_ns);
  if (ends_payload) end_payload();
}

std::span<const std::byte> UvcAssembler::take_header(std::span<const std::byte> bytes) {
  if (header_size_ == 0 && !bytes.empty()) {
    header_bytes_[header_size_++] = bytes.front();
    bytes = bytes.subspan(1);
  }
  const std::size_t length = std::to_integer<std::size_t>(header_bytes_[0]);
  const std::size_t missing = std::max(length, header_size_) - header_size_;
  const std::size_t taken = std::min(missing, bytes.size());
  std::copy_n(bytes.begin(), taken, header_bytes_.begin() + static_cast<std::ptrdiff_t>(header_size_));
  header_size_ += taken;
  if (taken == missing) begin_payload();
  return bytes.subspan(taken);
}

void UvcAssembler::begin_payload() {
  payload_ = parse_payload_header(std::span(header_bytes_).first(header_size_));
  is_in_payload_ = true;
  payload_size_ = 0;
  is_payload_hurt_ = false;
  if (!payload_) {
    lose(Loss::kTransport);
    return;
  }
  if (!picture_) return;
  const bool is_next = picture_->frame_id ? *picture_->frame_id != payload_->frame_id
                                          : last_frame_id_ && *last_frame_id_ == payload_->frame_id;
  if (is_next) finish_picture();
}

void UvcAssembler::append(std::span<const std::byte> bytes, std::int64_t host_ns) {
  if (!payload_ || bytes.empty()) return;
  open_picture();
  payload_size_ += bytes.size();
  picture_->host_ns = host_ns;
  // Twice the size: a whole picture may follow the remains of another (keep_only_last_payload).
  const std::size_t room = 2 * framing_.frame_bytes - std::min(2 * framing_.frame_bytes, picture_->bytes->size());
  if (bytes.size() > room) {
    picture_->is_bad = true;
    picture_->is_too_long = true;
  }
  const auto fitting = bytes.first(std::min(bytes.size(), room));
  picture_->bytes->insert(picture_->bytes->end(), fitting.begin(), fitting.end());
}

void UvcAssembler::end_payload() {
  const auto payload = std::exchange(payload_, std::nullopt);
  is_in_payload_ = false;
  header_size_ = 0;
  if (!payload) {
    if (framing_.is_one_payload && picture_) finish_picture();
    return;
  }
  if (payload->has_error) {
    if (!picture_) picture_.emplace().frame_id = payload->frame_id;
    picture_->is_bad = true;
  } else if (payload->is_end && picture_ && !is_payload_hurt_ && payload_size_ == framing_.frame_bytes) {
    keep_only_last_payload();
  }
  if (picture_ && !picture_->ticks) picture_->ticks = payload->presentation_ticks;
  if (picture_ && payload->frame_counter) picture_->frame_counter = payload->frame_counter;
  if (payload->is_end && picture_) finish_picture();
}

/// The payload is a whole picture by itself; what was there before it is another one's, and lost.
void UvcAssembler::keep_only_last_payload() {
  auto& bytes = *picture_->bytes;
  const bool is_alone = bytes.size() == framing_.frame_bytes && !picture_->is_bad && !picture_->is_doubtful;
  if (is_alone || bytes.size() < framing_.frame_bytes) return;
  count(loss_of(*picture_));
  bytes.erase(bytes.begin(), bytes.end() - static_cast<std::ptrdiff_t>(framing_.frame_bytes));
  picture_->is_bad = picture_->is_doubtful = false;
  picture_->ticks.reset();
}

void UvcAssembler::open_picture() {
  if (!picture_) picture_.emplace();
  if (!picture_->frame_id) picture_->frame_id = payload_->frame_id;
  if (!picture_->bytes) {
    picture_->bytes = std::make_shared<std::vector<std::byte>>();
    picture_->bytes->reserve(framing_.frame_bytes);
  }
}

void UvcAssembler::lose(Loss kind) {
  is_payload_hurt_ = true;
  if (picture_ && picture_->bytes) {
    picture_->is_bad = true;
  } else {
    if (!picture_) picture_.emplace();
    picture_->is_doubtful = true;
  }
  picture_->is_too_long = kind == Loss::kOverflow;
  if (framing_.is_one_payload && !is_in_payload_) finish_picture();
}

void UvcAssembler::restart() {
  is_in_payload_ = false;
  header_size_ = 0;
  payload_.reset();
  last_frame_id_.reset();
  if (!picture_) return;
  picture_->is_bad = true;
  finish_picture();
}

void UvcAssembler::finish_picture() {
  UnfinishedPicture picture = *std::exchange(picture_, std::nullopt);
  // Where nothing but a loss is known, the id will have flipped as always.
  if (picture.frame_id) {
    last_frame_id_ = picture.frame_id;
  } else if (last_frame_id_) {
    last_frame_id_ = !*last_frame_id_;
  }
  if (!picture.bytes) return count(loss_of(picture));
  if (picture.bytes->size() > framing_.frame_bytes) return count(Loss::kOverflow);
  if (picture.is_bad) return count(loss_of(picture));
  const bool is_whole = framing_.is_compressed ? !picture.is_doubtful && trim_to_jpeg(*picture.bytes)
                                               : picture.bytes->size() == framing_.frame_bytes;
  if (!is_whole) return count(loss_of(picture));
  deliver(std::move(picture));
}

void UvcAssembler::deliver(UnfinishedPicture picture) {
  const auto sequence = sequence_after(picture);
  if (!sequence) return count(Loss::kTransport);
  next_sequence_ = *sequence + 1;
  lost_since_delivered_ = 0;
  deliver_({std::move(picture.bytes), *sequence, picture.ticks, picture.host_ns});
}

/// Nothing: this very frame was delivered before.
std::optional<std::uint64_t> UvcAssembler::sequence_after(const UnfinishedPicture& picture) {
  const std::uint64_t counted_here = next_sequence_ + lost_since_delivered_;
  if (!picture.frame_counter) return counted_here;
  const auto last = std::exchange(last_counter_, picture.frame_counter);
  if (!last) return counted_here;
  const std::uint32_t step = *picture.frame_counter - *last;  // wraps as the counter does
  if (step == 0) return std::nullopt;
  if (step > kMaxCounterGap) return counted_here;
  const std::uint64_t missing = step - 1;
  losses_.device += missing - std::min<std::uint64_t>(missing, lost_since_delivered_);
  return next_sequence_ + missing;
}

void UvcAssembler::count(Loss kind) {
  ++lost_since_delivered_;
  ++(kind == Loss::kOverflow ? losses_.overflow : losses_.transport);
}

}  // namespace scanknit

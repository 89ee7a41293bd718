// Finite state entropy (Duda 2013, "Asymmetric numeral systems"), as LZFSE has it. Private to its decoder.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace scanknit {

/// Reads bits from the end of a payload to its start; the first bit read is the highest.
class BackwardBits {
 public:
  /// The last `unused` bits of the payload (0 to 7) hold nothing and must be 0.
  static std::optional<BackwardBits> of(std::span<const std::byte> payload, unsigned unused) {
    if (unused > 8 * payload.size()) return std::nullopt;
    BackwardBits bits(payload);
    if (bits.take(unused) != 0u) return std::nullopt;
    return bits;
  }

  /// At most 32 bits; nothing: there are not so many.
  [[nodiscard]] std::optional<std::uint32_t> take(unsigned count) {
    if (count > left_) return std::nullopt;
    left_ -= count;
    std::uint64_t bits = 0;
    const std::size_t first = left_ / 8, behind = (left_ + count + 7) / 8;
    for (std::size_t i = behind; i > first; --i) bits = bits << 8 | std::to_integer<std::uint64_t>(payload_[i - 1]);
    return static_cast<std::uint32_t>(bits >> left_ % 8 & ((std::uint64_t{1} << count) - 1));
  }

 private:
  explicit BackwardBits(std::span<const std::byte> payload) : payload_(payload), left_(8 * payload.size()) {}

  std::span<const std::byte> payload_;
  std::size_t left_;
};

/// What a state stands for, and how the next one is found: `base` and so many bits.
struct FseState {
  std::uint16_t symbol = 0;
  std::uint16_t base = 0;
  std::uint8_t bits = 0;
};

template <std::size_t States>
class FseDecoder {
 public:
  /// `frequencies`: how many states stand for each symbol. False: more than there are.
  [[nodiscard]] bool build(std::span<const std::uint16_t> frequencies) {
    used_ = 0;
    for (std::size_t symbol = 0; symbol < frequencies.size(); ++symbol) {
      const unsigned count = frequencies[symbol];
      if (count == 0) continue;
      if (count > States - used_) return false;
      // Of the states of a symbol the first need `bits` to tell the next state, the others one less.
      const auto bits = static_cast<unsigned>(std::countl_zero(count) - std::countl_zero(unsigned{States}));
      const unsigned with_more = (2 * unsigned{States} >> bits) - count;
      for (unsigned i = 0; i < count; ++i) {
        FseState& state = states_[used_++];
        state.symbol = static_cast<std::uint16_t>(symbol);
        state.bits = static_cast<std::uint8_t>(i < with_more ? bits : bits - 1);
        state.base =
            static_cast<std::uint16_t>(i < with_more ? ((count + i) << bits) - States : (i - with_more) << (bits - 1));
      }
    }
    return true;
  }

  /// The symbol of `state`, which becomes the next one. Nothing: the state stands for none, or the bits are used up.
  [[nodiscard]] std::optional<std::size_t> take(std::uint32_t& state, BackwardBits& bits) const {
    if (state >= used_) return std::nullopt;
    const FseState& now = states_[state];
    const auto more = bits.take(now.bits);
    if (!more) return std::nullopt;
    state = now.base + *more;
    return now.symbol;
  }

 private:
  std::array<FseState, States> states_{};
  std::size_t used_ = 0;
};

}  // namespace scanknit

// Access checks of the live view.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace scanknit {

/// 128 random bits from the kernel, as 32 hexadecimal digits.
[[nodiscard]] std::string random_token();

/// Compares in a time that depends only on the lengths.
[[nodiscard]] bool is_same_secret(std::string_view given, std::string_view secret);

/// True when a request's Host header names this computer: a numeric address, localhost, or the computer's own name
/// (also with .local); with any port, because tunnels change it. This refuses a web page elsewhere that points its own
/// name at this computer (DNS rebinding).
[[nodiscard]] bool is_own_host(std::string_view host);

/// True when a WebSocket's Origin header is the page from `host`, and not another web page.
[[nodiscard]] bool is_own_origin(std::string_view origin, std::string_view host);

/// The value of `name` in "a=1&b=2" (`separator` '&') or in a Cookie header ("; "); empty when it is missing.
[[nodiscard]] std::string_view value_of(std::string_view pairs, std::string_view name, std::string_view separator);

/// The page's URL at a numeric `host`, with the token if there is one.
[[nodiscard]] std::string link_to(const std::string& host, std::uint16_t port, const std::string& token);

/// Decodes "%20" to a space; empty when the text is not a valid encoding.
[[nodiscard]] std::string percent_decoded(std::string_view text);
/// Encodes a file name for a link.
[[nodiscard]] std::string percent_encoded(std::string_view text);

}  // namespace scanknit

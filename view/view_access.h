// ViewAccess: who may see the live view.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace scanknit {

/// 128 random bits of the kernel's, as 32 hexadecimal digits.
[[nodiscard]] std::string random_token();

/// In a time that depends on the lengths only.
[[nodiscard]] bool is_same_secret(std::string_view given, std::string_view secret);

/// Whether a request's Host header is a way to name this computer: a numeric address, localhost, or the computer's own
/// name (also with .local); any port, since tunnels change it. A web page elsewhere that points its own name at this
/// computer (DNS rebinding) is refused by it.
[[nodiscard]] bool is_own_host(std::string_view host);

/// Whether a WebSocket's Origin header is the page that came from `host`, and no other web page.
[[nodiscard]] bool is_own_origin(std::string_view origin, std::string_view host);

/// The value of `name` in "a=1&b=2" (`separator` '&') or in a Cookie header ("; "); empty when it is not there.
[[nodiscard]] std::string_view value_of(std::string_view pairs, std::string_view name, std::string_view separator);

/// The page's address at a numeric `host`, with the token if there is one.
[[nodiscard]] std::string link_to(const std::string& host, std::uint16_t port, const std::string& token);

/// "%20" becomes a space; empty where the text is no such encoding.
[[nodiscard]] std::string percent_decoded(std::string_view text);
/// What a link to a file of that name must say.
[[nodiscard]] std::string percent_encoded(std::string_view text);

}  // namespace scanknit

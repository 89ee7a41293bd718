#include "view/view_access.h"

#include <arpa/inet.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>

#include "core/check.h"

namespace scanknit {
namespace {

constexpr std::string_view kHexDigits = "0123456789abcdef";

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

std::string computer_name() {
  std::array<char, 256> name{};
  if (gethostname(name.data(), name.size() - 1) != 0) return "";
  return lower(name.data());
}

bool is_numeric_address(const std::string& text) {
  std::array<unsigned char, sizeof(in6_addr)> address{};
  return inet_pton(AF_INET, text.c_str(), address.data()) == 1 ||
         inet_pton(AF_INET6, text.c_str(), address.data()) == 1;
}

/// "[::1]:80" -> "::1", "name:80" -> "name".
std::string_view without_port(std::string_view host) {
  if (!host.empty() && host.front() == '[') {
    const std::size_t end = host.find(']');
    return end == std::string_view::npos ? std::string_view() : host.substr(1, end - 1);
  }
  return host.substr(0, host.find(':'));
}

int digit_of(char c) {
  const std::size_t at = kHexDigits.find(static_cast<char>(std::tolower(static_cast<unsigned char>(c))));
  return at == std::string_view::npos ? -1 : static_cast<int>(at);
}

}  // namespace

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  SCANKNIT_CHECK(getrandom(bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()));
  std::string token;
  for (const unsigned char byte : bytes) {
    token += kHexDigits[byte >> 4];
    token += kHexDigits[byte & 15u];
  }
  return token;
}

bool is_same_secret(std::string_view given, std::string_view secret) {
  if (given.size() != secret.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < secret.size(); ++i) {
    difference |= static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(secret[i]);
  }
  return difference == 0;
}

bool is_own_host(std::string_view host) {
  if (host.empty()) return false;
  const std::string name = lower(without_port(host));
  std::string_view port = host.substr(std::min(host.size(), host.front() == '[' ? name.size() + 2 : name.size()));
  if (!port.empty() && port.front() == ':') port.remove_prefix(1);
  if (name.empty() || port.find_first_not_of("0123456789") != std::string_view::npos) return false;
  const std::string own = computer_name();
  return name == "localhost" || is_numeric_address(name) || (!own.empty() && (name == own || name == own + ".local"));
}

bool is_own_origin(std::string_view origin, std::string_view host) {
  return lower(origin) == "http://" + lower(host);
}

std::string_view value_of(std::string_view pairs, std::string_view name, std::string_view separator) {
  while (!pairs.empty()) {
    const std::size_t end = pairs.find(separator);
    const std::string_view pair = pairs.substr(0, end);
    const std::size_t equals = pair.find('=');
    if (equals != std::string_view::npos && pair.substr(0, equals) == name) return pair.substr(equals + 1);
    if (end == std::string_view::npos) break;
    pairs.remove_prefix(end + separator.size());
  }
  return {};
}

std::string link_to(const std::string& host, std::uint16_t port, const std::string& token) {
  const bool is_v6 = host.find(':') != std::string::npos;
  const std::string authority = (is_v6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
  return "http://" + authority + "/" + (token.empty() ? "" : "?token=" + token);
}

std::string percent_decoded(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      result += text[i];
      continue;
    }
    const int high = i + 2 < text.size() ? digit_of(text[i + 1]) : -1;
    const int low = i + 2 < text.size() ? digit_of(text[i + 2]) : -1;
    if (high < 0 || low < 0) return "";
    result += static_cast<char>(16 * high + low);
    i += 2;
  }
  return result;
}

std::string percent_encoded(std::string_view text) {
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || c == '.' || c == '-' || c == '_') {
      result += c;
      continue;
    }
    result += '%';
    result += kHexDigits[byte >> 4];
    result += kHexDigits[byte & 15u];
  }
  return result;
}

}  // namespace scanknit

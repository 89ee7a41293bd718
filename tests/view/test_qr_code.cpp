// The code in the terminal, cell by cell.
#include <gtest/gtest.h>

#include <algorithm>
#include <qrcodegen/qrcodegen.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "view/qr_code.h"

namespace scanknit {
namespace {

const std::string kLink = "http://192.168.100.100:65535/?token=0123456789abcdef0123456789abcdef";

/// Rows of the terminal's half cells: true is dark.
std::vector<std::vector<bool>> drawn(const std::string& code) {
  std::vector<std::vector<bool>> rows;
  std::istringstream lines(code);
  for (std::string line; std::getline(lines, line);) {
    line = line.substr(line.find('m') + 1);
    line = line.substr(0, line.find('\x1b'));
    std::vector<bool> upper;
    std::vector<bool> lower;
    while (!line.empty()) {
      const std::string cell = line.substr(0, line.front() == ' ' ? 1 : 3);
      upper.push_back(cell == "\u2588" || cell == "\u2580");
      lower.push_back(cell == "\u2588" || cell == "\u2584");
      line.erase(0, cell.size());
    }
    rows.push_back(upper);
    rows.push_back(lower);
  }
  return rows;
}

TEST(QrCode, IsTheLinksCodeWithALightMargin) {
  const auto expected = qrcodegen::QrCode::encodeText(kLink.c_str(), qrcodegen::QrCode::Ecc::LOW);
  const auto rows = drawn(qr_code(kLink, 80));
  const int margin = (static_cast<int>(rows.front().size()) - expected.getSize()) / 2;
  EXPECT_GE(margin, 2);
  ASSERT_GE(static_cast<int>(rows.size()), expected.getSize() + 2 * margin);
  for (int y = 0; y < static_cast<int>(rows.size()); ++y) {
    for (int x = 0; x < static_cast<int>(rows.front().size()); ++x) {
      EXPECT_EQ(rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)],
                expected.getModule(x - margin, y - margin))
          << x << ' ' << y;
    }
  }
}

TEST(QrCode, FitsATerminalOf24Lines) {
  const std::string code = qr_code(kLink, 80);
  EXPECT_LE(std::count(code.begin(), code.end(), '\n'), 24);
}

TEST(QrCode, IsNotDrawnWhereItsLinesWouldBeWrapped) {
  const int columns = static_cast<int>(drawn(qr_code(kLink, 80)).front().size());
  EXPECT_NE(qr_code(kLink, columns), "");
  EXPECT_EQ(qr_code(kLink, columns - 1), "");
}

TEST(QrCode, WhatIsTooLongGivesNone) {
  EXPECT_EQ(qr_code(std::string(5'000, 'x'), 1'000), "");
}

}  // namespace
}  // namespace scanknit

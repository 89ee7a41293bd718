#include <gtest/gtest.h>

#include <limits>

#include "core/files/quantity.h"

namespace scanknit {
namespace {

TEST(Length, MillimetresCentimetresAndMetresGiveTheSameBitsAsPlainMetres) {
  EXPECT_EQ(parse_length("2mm")->metres, 0.002);
  EXPECT_EQ(parse_length("0.4 cm")->metres, 0.004);
  EXPECT_EQ(parse_length("3 m")->metres, 3.0);
  EXPECT_EQ(parse_length("0.002")->metres, 0.002);
}

TEST(Length, TellsWhetherAUnitWasWritten) {
  EXPECT_TRUE(parse_length("2 m")->has_unit);
  EXPECT_FALSE(parse_length("2")->has_unit);
}

TEST(Length, RefusesWhatIsNoLength) {
  for (const char* text : {"", "mm", "two", "2 inches", "2 mm 3", "nan", "inf", "1e999", "0x10", "2,5 mm", "--2"}) {
    EXPECT_FALSE(parse_length(text)) << text;
  }
}

TEST(Length, IsWrittenSoThatItReadsBackAsTheSameBits) {
  for (const double metres : {0.0, 0.004, 0.0012, 1.0 / 3.0, 5.0, 0.1, 1e-9, 0.30000000000000004}) {
    EXPECT_EQ(parse_length(format_length(metres))->metres, metres) << format_length(metres);
  }
}

TEST(Length, IsWrittenInTheUnitThatPeopleUse) {
  EXPECT_EQ(format_length(0.004), "4 mm");
  EXPECT_EQ(format_length(3), "3 m");
  EXPECT_EQ(format_length(0), "0");
}

TEST(Memory, TakesUnitsAndPlainMebibytes) {
  EXPECT_EQ(parse_memory_mib("2GiB"), 2048);
  EXPECT_EQ(parse_memory_mib("512 MiB"), 512);
  EXPECT_EQ(parse_memory_mib("4096"), 4096);
  EXPECT_EQ(parse_memory_mib("1.5 GiB"), 1536);
}

TEST(Memory, RefusesWhatIsNoMemory) {
  for (const char* text : {"", "lots", "2 GB", "1e300 GiB", "nan"}) EXPECT_FALSE(parse_memory_mib(text)) << text;
}

TEST(Number, RefusesNanAndInfinity) {
  EXPECT_FALSE(parse_finite("nan"));
  EXPECT_FALSE(parse_finite("-inf"));
  EXPECT_FALSE(parse_finite("1e400"));
}

TEST(Number, IsWrittenSoThatItReadsBackAsTheSameBits) {
  for (const double value : {0.1, 1.0 / 3.0, 1e-300, std::numeric_limits<double>::max(), -0.0019}) {
    EXPECT_EQ(parse_finite(format_number(value)), value);
  }
}

}  // namespace
}  // namespace scanknit

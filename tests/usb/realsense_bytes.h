// Calibration tables as a D400 camera would send them.
#pragma once

#include <array>

#include "acquire/usb/realsense_tables.h"
#include "core/files/crc32.h"
#include "tests/usb/usb_bytes.h"

namespace scanknit::test {

/// The body after a header that fits it.
inline Bytes realsense_table(std::uint32_t id, const Bytes& body) {
  Bytes out{1, 2};
  out.u16(id).u32(static_cast<std::uint32_t>(body.size())).u32(0).u32(crc32(body.span()));
  return out.add(body);
}

/// Baseline 50 mm. 640x480 (its third entry): fx 380, fy 381, cx 319, cy 241; 1280x720 twice that of 640x360; others
/// zero.
inline Bytes depth_table() {
  Bytes body;
  body.fill(144).f32(-50).fill(92).fill(16).f32(640).f32(640).f32(639).f32(359).f32(380).f32(381).f32(319).f32(241);
  return realsense_table(kDepthTable, body.fill(10 * 16 + 64));
}

/// Calibrated at 1920x1080: fx = fy = 1400 pixels, centre in the middle; 15 mm to the right of the depth camera.
inline Bytes colour_table() {
  Bytes body;
  for (const float value : {1400.0f / 960, 0.0f, 0.0f, 0.0f, 1400.0f / 540, 0.0f, 0.0f, 0.0f, 1.0f}) body.f32(value);
  for (const float value : {0.01f, -0.02f, 0.001f, 0.002f, 0.0f}) body.f32(value);
  body.fill(72).u16(1920).u16(1080).fill(36);
  for (const float value : {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f}) body.f32(value);
  return realsense_table(kColourTable, body.f32(-15).f32(0).f32(0).fill(24));
}

/// Firmware 5.12.7.100.
inline Bytes identity_data() {
  return Bytes{}.fill(12).add({100, 7, 12, 5}).fill(32).add({0x01, 0x23, 0x45, 0x67, 0x89, 0xAB}).fill(200);
}

}  // namespace scanknit::test

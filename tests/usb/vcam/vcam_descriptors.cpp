#include "tests/usb/usb_bytes.h"
#include "tests/usb/vcam/vcam.h"

namespace scanknit::test {
namespace {

constexpr int kVideo = 0x0E;
constexpr std::uint32_t kIntervals[] = {111111, 166666, 333333, 666666};  // 90, 60, 30, 15 frames a second

Bytes interface(int number, int alternate, int endpoints, int subclass) {
  return descriptor({0x04, number, alternate, endpoints, kVideo, subclass, 0, 0});
}

Bytes control_interface(const VcamOptions& options, int number, int terminal, int processing) {
  Bytes bytes = interface(number, 0, 0, 1);
  bytes.add(descriptor(Bytes{0x24, 0x01}.u16(options.uvc_version).u16(0).u32(48'000'000).u8(1).u8(number + 1)));
  bytes.add(descriptor(Bytes{0x24, 0x02, terminal}.u16(0x0201).fill(6).add({3, 0x0A, 0, 0})));
  Bytes unit = {0x24, 0x05, processing, terminal, 0, 0, 2, 0, 0x10, 0};
  if (options.uvc_version >= 0x0110) unit.u8(0);  // television standards
  return bytes.add(descriptor(unit));
}

/// Where the pictures come out after the unit `source`.
Bytes output_terminal(int source) {
  return descriptor(Bytes{0x24, 0x03, 4}.u16(0x0101).add({0, source, 0}));
}

Bytes extension_unit() {
  const Bytes guid = {0xCB, 0x6C, 0x60, 0xC9, 0x4C, 0x59, 0x25, 0x4D, 0xAF, 0x47, 0xCC, 0xC4, 0x96, 0x43, 0x59, 0x95};
  return descriptor(Bytes{0x24, 0x06, 3}.add(guid).u8(17).u8(1).u8(2).u8(3).add({0xFF, 0xDD, 0x01}).u8(0));
}

/// FRAME_BASED as a D421 has it.
Bytes sensor_format(const VcamOptions& options, int index, const std::string& code) {
  Bytes bytes = descriptor(Bytes{0x24, 0x10, index, 1}.add(format_guid(code)).u8(16).u8(1).fill(5));
  Bytes size{0x24, 0x11, 1, 0};
  const auto width = static_cast<std::uint32_t>(options.width), height = static_cast<std::uint32_t>(options.height);
  size.u16(width).u16(height).u32(0).u32(0).u32(333333).u8(std::size(kIntervals)).u32(2 * width);
  for (const std::uint32_t interval : kIntervals) size.u32(interval);
  return bytes.add(descriptor(size));
}

Bytes colour_size(const VcamOptions& options, int subtype) {
  Bytes size{0x24, subtype, 1, 0};
  const auto width = static_cast<std::uint32_t>(options.width), height = static_cast<std::uint32_t>(options.height);
  size.u16(width).u16(height).u32(0).u32(0).u32(2 * width * height).u32(333333);
  size.u8(std::size(kIntervals));
  for (const std::uint32_t interval : kIntervals) size.u32(interval);
  return descriptor(size);
}

Bytes bulk_endpoint(const VcamOptions& options, int address) {
  Bytes bytes = descriptor(Bytes{0x05, address, 0x02}.u16(options.speed_mbit >= 5000 ? 1024 : 512).u8(0));
  return options.speed_mbit >= 5000 ? bytes.add(descriptor({0x30, 15, 0, 0, 0})) : bytes;
}

/// Silent, 8 and 24 MB/s: one and three packets of 1024 bytes a microframe.
Bytes isochronous_interface(int number, const Bytes& classes, int endpoint) {
  Bytes bytes = interface(number, 0, 0, 2).add(classes);
  bytes.add(interface(number, 1, 1, 2)).add(descriptor(Bytes{0x05, endpoint, 0x05}.u16(1024).u8(1)));
  return bytes.add(interface(number, 2, 1, 2)).add(descriptor(Bytes{0x05, endpoint, 0x05}.u16(0x1400).u8(1)));
}

Bytes depth_stream(const VcamOptions& options) {
  Bytes classes = options.has_infrared
                      ? descriptor({0x24, 0x01, 4, 0, 0, Vcam::kDepthEndpoint, 0, 4, 0, 0, 0, 1, 0, 0, 0, 0})
                            .add(sensor_format(options, 2, "UYVY"))
                            .add(sensor_format(options, 3, "Y16 "))
                            .add(sensor_format(options, Vcam::kPairFormat, "Y8I "))
                      : descriptor({0x24, 0x01, 1, 0, 0, Vcam::kDepthEndpoint, 0, 4, 0, 0, 0, 1, 0});
  classes.add(sensor_format(options, 1, options.depth_code)).add(descriptor({0x24, 0x0D, 1, 1, 4}));
  if (options.is_isochronous) {
    return isochronous_interface(1, classes, Vcam::kDepthEndpoint);
  }
  Bytes bytes = interface(1, 0, 1, 2);
  if (options.hangs_on_endpoint) return bytes.add(bulk_endpoint(options, Vcam::kDepthEndpoint)).add(classes);
  return bytes.add(classes).add(bulk_endpoint(options, Vcam::kDepthEndpoint));
}

Bytes colour_function(const VcamOptions& options) {
  Bytes bytes = descriptor({0x0B, 2, 2, kVideo, 3, 0, 0});
  bytes.add(control_interface(options, 2, 1, 2)).add(output_terminal(2));
  const int formats = options.has_yuyv ? 2 : 1;
  Bytes classes = descriptor(Bytes{0x24, 0x01, formats, 0, 0, Vcam::kColourEndpoint, 0, 4, 0, 0, 0, 1}.fill(formats));
  if (options.has_yuyv) {
    classes.add(descriptor(Bytes{0x24, 0x04, 1, 1}.add(format_guid("YUY2")).u8(16).u8(1).fill(4)))
        .add(colour_size(options, 0x05));
  }
  classes.add(descriptor({0x24, 0x06, formats, 1, 1, 1, 0, 0, 0, 0})).add(colour_size(options, 0x07));
  if (options.has_isochronous_colour) return bytes.add(isochronous_interface(3, classes, Vcam::kColourEndpoint));
  return bytes.add(interface(3, 0, 1, 2)).add(classes).add(bulk_endpoint(options, Vcam::kColourEndpoint));
}

}  // namespace

std::vector<std::byte> Vcam::configuration() const {
  Bytes parts = descriptor({0x0B, 0, 2, kVideo, 3, 0, 0});
  parts.add(control_interface(options_, 0, 1, 2)).add(extension_unit()).add(output_terminal(3));
  parts.add(depth_stream(options_));
  if (options_.has_colour) parts.add(colour_function(options_));
  Bytes bytes{9, 2};
  // bMaxPower counts 8 mA at SuperSpeed: 55 are 440 mA.
  bytes.u16(static_cast<std::uint32_t>(parts.size() + 9)).u8(options_.has_colour ? 4 : 2).add({1, 0, 0x80, 55});
  return bytes.add(parts).vector();
}

std::vector<std::byte> Vcam::descriptors() const {
  Bytes bytes{18, 1};
  bytes.u16(options_.speed_mbit >= 5000 ? 0x0320 : 0x0200)
      .add({0xEF, 0x02, 0x01, options_.speed_mbit >= 5000 ? 9 : 64});
  bytes.u16(options_.vendor).u16(options_.product).u16(0x50C0).add({1, 2, 3, 1});
  auto all = bytes.vector();
  const auto rest = configuration();
  all.insert(all.end(), rest.begin(), rest.end());
  return all;
}

}  // namespace scanknit::test

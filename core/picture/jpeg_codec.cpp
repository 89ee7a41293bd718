#include "core/picture/jpeg_codec.h"

// libjpeg's header needs this one before it.
#include <cstdio>

#include <jerror.h>
#include <jpeglib.h>

#include <algorithm>
#include <csetjmp>
#include <exception>
#include <new>
#include <utility>

namespace scanknit {
namespace {

static_assert(sizeof(Rgb8) == 3 && sizeof(JSAMPLE) == 1);  // rows of pixels are rows of libjpeg's samples

// libjpeg leaves its functions by longjmp. What has a destructor lives in the classes below, outside of the functions
// that call setjmp.

struct Errors : jpeg_error_mgr {
  std::jmp_buf outside{};
};

[[noreturn]] void leave(j_common_ptr jpeg) {
  std::longjmp(static_cast<Errors*>(jpeg->err)->outside, 1);
}

void keep_silent(j_common_ptr /*jpeg*/, int /*level*/) {}

/// For a struct that is not created yet.
template <typename Jpeg>
void set_errors(Jpeg& jpeg, Errors& errors) {
  jpeg.err = jpeg_std_error(&errors);
  errors.error_exit = leave;
  errors.emit_message = keep_silent;
}

void begin_source(j_decompress_ptr /*jpeg*/) {}

boolean has_no_more(j_decompress_ptr /*jpeg*/) {
  return FALSE;
}

void skip_bytes(j_decompress_ptr jpeg, long count) {
  jpeg_source_mgr& source = *jpeg->src;
  const std::size_t skipped = count < 0 ? 0 : std::min(static_cast<std::size_t>(count), source.bytes_in_buffer);
  source.next_input_byte += skipped;
  source.bytes_in_buffer -= skipped;
}

void end_source(j_decompress_ptr /*jpeg*/) {}

/// Adobe's CMYK, whose samples are inverted: 255 is no ink.
Rgb8 from_cmyk(std::span<const JSAMPLE, 4> cmyk) {
  const int k = cmyk[3];
  const auto mix = [k](int ink) { return static_cast<std::uint8_t>(k - ((255 - ink) * k >> 8)); };
  return {mix(cmyk[0]), mix(cmyk[1]), mix(cmyk[2])};
}

class JpegReader {
 public:
  JpegReader(std::span<const std::byte> bytes, int width) : cmyk_(4 * static_cast<std::size_t>(width)) {
    set_errors(jpeg_, errors_);
    source_.next_input_byte = reinterpret_cast<const JOCTET*>(bytes.data());
    source_.bytes_in_buffer = bytes.size();
    source_.init_source = begin_source;
    source_.fill_input_buffer = has_no_more;
    source_.skip_input_data = skip_bytes;
    source_.resync_to_restart = jpeg_resync_to_restart;
    source_.term_source = end_source;
  }
  ~JpegReader() { jpeg_destroy_decompress(&jpeg_); }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;

  /// False if the file is corrupt, or of another size than `image`.
  [[nodiscard]] bool read(ColourImage& image) {
    if (setjmp(errors_.outside) != 0) return false;
    jpeg_create_decompress(&jpeg_);
    jpeg_.src = &source_;
    if (jpeg_read_header(&jpeg_, TRUE) != JPEG_HEADER_OK) return false;
    const bool is_cmyk = jpeg_.num_components == 4;
    jpeg_.out_color_space = is_cmyk ? JCS_CMYK : JCS_RGB;
    if (jpeg_start_decompress(&jpeg_) == FALSE) return false;
    if (jpeg_.output_width != static_cast<JDIMENSION>(image.width()) ||
        jpeg_.output_height != static_cast<JDIMENSION>(image.height())) {
      return false;
    }
    for (int y = 0; y < image.height(); ++y) {
      JSAMPROW row = is_cmyk ? cmyk_.data() : reinterpret_cast<JSAMPROW>(image.row(y).data());
      if (jpeg_read_scanlines(&jpeg_, &row, 1) != 1) return false;
      if (is_cmyk) convert_cmyk(image.row(y));
    }
    return true;
  }

  [[nodiscard]] bool lacks_memory() const { return errors_.msg_code == JERR_OUT_OF_MEMORY; }

 private:
  void convert_cmyk(std::span<Rgb8> row) const {
    const std::span<const JSAMPLE> samples = cmyk_;
    for (std::size_t x = 0; x < row.size(); ++x) row[x] = from_cmyk(samples.subspan(4 * x).first<4>());
  }

  Errors errors_;
  jpeg_decompress_struct jpeg_{};
  jpeg_source_mgr source_{};
  std::vector<JSAMPLE> cmyk_;  // one row
};

struct Destination : jpeg_destination_mgr {
  std::vector<std::uint8_t> bytes;
};

constexpr std::size_t kFirstBytes = 4096;

/// Makes room after the first `used` bytes.
void make_room(j_compress_ptr jpeg, std::size_t used) {
  auto& destination = *static_cast<Destination*>(jpeg->dest);
  bool has_room = true;
  try {
    destination.bytes.resize(used == 0 ? kFirstBytes : 2 * used);
  } catch (const std::exception&) {  // std::bad_alloc, std::length_error
    has_room = false;
  }
  if (!has_room) {
    jpeg->err->msg_code = JERR_OUT_OF_MEMORY;
    leave(reinterpret_cast<j_common_ptr>(jpeg));
  }
  destination.next_output_byte = destination.bytes.data() + used;
  destination.free_in_buffer = destination.bytes.size() - used;
}

void begin_destination(j_compress_ptr jpeg) {
  make_room(jpeg, 0);
}

boolean grow_destination(j_compress_ptr jpeg) {
  make_room(jpeg, static_cast<Destination*>(jpeg->dest)->bytes.size());
  return TRUE;
}

void end_destination(j_compress_ptr jpeg) {
  auto& destination = *static_cast<Destination*>(jpeg->dest);
  destination.bytes.resize(destination.bytes.size() - destination.free_in_buffer);
}

class JpegWriter {
 public:
  JpegWriter() {
    set_errors(jpeg_, errors_);
    destination_.init_destination = begin_destination;
    destination_.empty_output_buffer = grow_destination;
    destination_.term_destination = end_destination;
  }
  ~JpegWriter() { jpeg_destroy_compress(&jpeg_); }
  JpegWriter(const JpegWriter&) = delete;
  JpegWriter& operator=(const JpegWriter&) = delete;

  [[nodiscard]] bool write(const ColourImage& image, int quality) {
    if (setjmp(errors_.outside) != 0) return false;
    jpeg_create_compress(&jpeg_);
    jpeg_.dest = &destination_;
    jpeg_.image_width = static_cast<JDIMENSION>(image.width());
    jpeg_.image_height = static_cast<JDIMENSION>(image.height());
    jpeg_.input_components = 3;
    jpeg_.in_color_space = JCS_RGB;
    jpeg_set_defaults(&jpeg_);
    jpeg_set_quality(&jpeg_, quality, TRUE);
    jpeg_start_compress(&jpeg_, TRUE);
    for (int y = 0; y < image.height(); ++y) {
      // libjpeg only reads these samples, but its signature does not say so.
      auto* row = reinterpret_cast<JSAMPROW>(const_cast<Rgb8*>(image.row(y).data()));
      jpeg_write_scanlines(&jpeg_, &row, 1);
    }
    jpeg_finish_compress(&jpeg_);
    return true;
  }

  [[nodiscard]] std::vector<std::uint8_t> take() { return std::move(destination_.bytes); }
  [[nodiscard]] bool lacks_memory() const { return errors_.msg_code == JERR_OUT_OF_MEMORY; }

 private:
  Errors errors_;
  jpeg_compress_struct jpeg_{};
  Destination destination_;
};

}  // namespace

Result<ColourImage> decode_jpeg(std::span<const std::byte> bytes, const JpegHeader& header) {
  auto image = ColourImage::uninitialised(header.width, header.height);
  JpegReader reader(bytes, header.width);
  if (reader.read(image)) return image;
  if (reader.lacks_memory()) throw std::bad_alloc();
  return Error{ErrorCode::kInput, "the picture's compressed data are corrupt"};
}

Result<std::vector<std::uint8_t>> encode_jpeg(const ColourImage& image, int quality) {
  if (image.empty()) return Error{ErrorCode::kOutput, "a picture without pixels cannot be written"};
  JpegWriter writer;
  if (writer.write(image, quality)) return writer.take();
  if (writer.lacks_memory()) throw std::bad_alloc();
  return Error{ErrorCode::kOutput, "the picture could not be encoded as JPEG"};
}

}  // namespace scanknit

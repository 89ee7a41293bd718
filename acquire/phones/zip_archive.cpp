#include "acquire/phones/zip_archive.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

constexpr std::uint32_t kFileHeader = 0x04034b50, kListHeader = 0x02014b50, kEndRecord = 0x06054b50;
constexpr std::uint32_t kEndRecord64 = 0x06064b50, kEndLocator64 = 0x07064b50;
constexpr std::uint16_t kExtra64 = 1;  // the id of the extra field with sizes of 64 bits
constexpr std::uint32_t kIn64 = 0xFFFFFFFF;
constexpr std::uint16_t kEncrypted = 1, kSizesBehind = 8;  // flags
constexpr std::uint16_t kStored = 0, kDeflated = 8;        // methods
constexpr std::size_t kFileHeaderBytes = 30, kListHeaderBytes = 46, kEndRecordBytes = 22, kEndLocator64Bytes = 20,
                      kEndRecord64Bytes = 56, kMostComment = 65535;

using ZipEntries = std::map<std::string, ZipArchive::Entry>;

struct ListPlace {
  std::uint64_t at = 0, bytes = 0;
};

std::optional<std::vector<std::byte>> bytes_at(const RandomAccess& file, std::uint64_t at, std::uint64_t count) {
  if (at > file.size() || count > file.size() - at) return std::nullopt;
  std::vector<std::byte> bytes(static_cast<std::size_t>(count));
  if (!file.read(at, bytes)) return std::nullopt;
  return bytes;
}

std::uint32_t take32(ByteReader& reader) {
  return reader.little_endian<std::uint32_t>().value_or(0);
}

/// The next name, as bytes.
std::optional<std::string> take_name(ByteReader& reader, std::size_t count) {
  const auto bytes = reader.take(count);
  if (!bytes) return std::nullopt;
  std::string name;
  for (const std::byte letter : *bytes) name += std::to_integer<char>(letter);
  return name;
}

/// Numbers that do not fit 32 bits are in an extra field, in this order.
bool widen(std::span<const std::byte> extras, std::initializer_list<std::uint64_t*> numbers) {
  const auto is_wide = [](const std::uint64_t* number) { return *number == kIn64; };
  if (std::none_of(numbers.begin(), numbers.end(), is_wide)) return true;
  ByteReader reader(extras);
  for (;;) {
    const auto id = reader.little_endian<std::uint16_t>(), bytes = reader.little_endian<std::uint16_t>();
    const auto field = bytes ? reader.take(*bytes) : std::nullopt;
    if (!field) return false;
    if (*id != kExtra64) continue;
    ByteReader wide(*field);
    for (std::uint64_t* number : numbers) {
      if (!is_wide(number)) continue;
      const auto value = wide.little_endian<std::uint64_t>();
      if (!value) return false;
      *number = *value;
    }
    return true;
  }
}

std::optional<ListPlace> list_place_64(const RandomAccess& file, std::uint64_t end_record_at) {
  if (end_record_at < kEndLocator64Bytes) return std::nullopt;
  const auto locator = bytes_at(file, end_record_at - kEndLocator64Bytes, kEndLocator64Bytes);
  if (!locator) return std::nullopt;
  ByteReader reader(*locator);
  if (take32(reader) != kEndLocator64) return std::nullopt;
  (void)take32(reader);  // the disk
  const auto record = bytes_at(file, reader.little_endian<std::uint64_t>().value_or(0), kEndRecord64Bytes);
  if (!record) return std::nullopt;
  ByteReader from(*record);
  constexpr std::size_t kBeforeSizes = 40;
  if (take32(from) != kEndRecord64 || !from.take(kBeforeSizes - 4)) return std::nullopt;
  ListPlace place;
  place.bytes = from.little_endian<std::uint64_t>().value_or(0);
  place.at = from.little_endian<std::uint64_t>().value_or(0);
  return place;
}

/// By the record at the archive's end, behind which there may be a comment.
std::optional<ListPlace> find_list(const RandomAccess& file) {
  const std::uint64_t count = std::min<std::uint64_t>(file.size(), kEndRecordBytes + kMostComment);
  const std::uint64_t first = file.size() - count;
  const auto end = bytes_at(file, first, count);
  if (!end || count < kEndRecordBytes) return std::nullopt;
  for (std::size_t at = end->size() - kEndRecordBytes + 1; at-- > 0;) {
    ByteReader reader(std::span<const std::byte>(*end).subspan(at));
    if (take32(reader) != kEndRecord) continue;
    constexpr std::size_t kBeforeSizes = 12;
    (void)reader.take(kBeforeSizes - 4);
    ListPlace place;
    place.bytes = take32(reader);
    place.at = take32(reader);
    const auto comment = reader.little_endian<std::uint16_t>();
    if (!comment || *comment != reader.remaining()) continue;
    return place.at == kIn64 || place.bytes == kIn64 ? list_place_64(file, first + at) : place;
  }
  return std::nullopt;
}

/// Nothing: the list is missing or damaged.
std::optional<ZipEntries> read_list(const RandomAccess& file, const Limits& limits) {
  const auto place = find_list(file);
  if (!place || place->bytes > limits.max_text_bytes) return std::nullopt;
  const auto list = bytes_at(file, place->at, place->bytes);
  if (!list) return std::nullopt;
  ZipEntries entries;
  ByteReader reader(*list);
  while (reader.remaining() > 0) {
    const auto fixed = reader.take(kListHeaderBytes);
    if (!fixed) return std::nullopt;
    ByteReader from(*fixed);
    if (take32(from) != kListHeader) return std::nullopt;
    ZipArchive::Entry entry;
    (void)take32(from);  // versions
    entry.flags = *from.little_endian<std::uint16_t>();
    entry.method = *from.little_endian<std::uint16_t>();
    (void)take32(from);  // time and date
    entry.crc = take32(from);
    entry.packed_bytes = take32(from);
    entry.unpacked_bytes = take32(from);
    const auto name_bytes = *from.little_endian<std::uint16_t>();
    const auto extra_bytes = *from.little_endian<std::uint16_t>(), comment = *from.little_endian<std::uint16_t>();
    (void)from.take(2 + 2 + 4);  // disk, attributes
    entry.header_at = take32(from);
    auto name = take_name(reader, name_bytes);
    const auto extras = reader.take(extra_bytes);
    if (!name || !extras || !reader.take(comment) ||
        !widen(*extras, {&entry.unpacked_bytes, &entry.packed_bytes, &entry.header_at})) {
      return std::nullopt;
    }
    entries.insert_or_assign(*std::move(name), entry);
  }
  return entries;
}

/// The header of a file before its bytes, and where these begin.
struct ZipFileHeader {
  ZipArchive::Entry entry;
  std::string name;
  std::uint64_t bytes_at = 0;
};

std::optional<ZipFileHeader> read_file_header(const RandomAccess& file, std::uint64_t at) {
  const auto fixed = bytes_at(file, at, kFileHeaderBytes);
  if (!fixed) return std::nullopt;
  ByteReader from(*fixed);
  if (take32(from) != kFileHeader) return std::nullopt;
  ZipFileHeader header;
  ZipArchive::Entry& entry = header.entry;
  entry.header_at = at;
  (void)from.take(2);  // version
  entry.flags = *from.little_endian<std::uint16_t>();
  entry.method = *from.little_endian<std::uint16_t>();
  (void)take32(from);  // time and date
  entry.crc = take32(from);
  entry.packed_bytes = take32(from);
  entry.unpacked_bytes = take32(from);
  const auto name_bytes = *from.little_endian<std::uint16_t>(), extra_bytes = *from.little_endian<std::uint16_t>();
  const auto rest = bytes_at(file, at + kFileHeaderBytes, std::uint64_t{name_bytes} + extra_bytes);
  if (!rest) return std::nullopt;
  ByteReader reader(*rest);
  header.name = take_name(reader, name_bytes).value_or("");
  const auto extras = reader.take(extra_bytes);
  if (!extras || !widen(*extras, {&entry.unpacked_bytes, &entry.packed_bytes})) return std::nullopt;
  header.bytes_at = at + kFileHeaderBytes + rest->size();
  return header;
}

/// One file after the other, up to one that is cut, damaged, or does not state its size before its bytes.
ZipEntries walk_files(const RandomAccess& file, const Limits& limits) {
  constexpr std::size_t kMostPerFrame = 5;
  ZipEntries entries;
  std::uint64_t at = 0;
  while (entries.size() < kMostPerFrame * limits.max_frames) {
    auto header = read_file_header(file, at);
    if (!header || (header->entry.flags & kSizesBehind) != 0) break;
    if (header->entry.packed_bytes > file.size() - header->bytes_at) break;
    at = header->bytes_at + header->entry.packed_bytes;
    entries.insert_or_assign(std::move(header->name), header->entry);
  }
  return entries;
}

/// Raw deflate to exactly `count` bytes.
std::optional<std::vector<std::byte>> inflated(const std::vector<std::byte>& packed, std::size_t count) {
  constexpr int kRaw = -15;  // zlib's largest window, without a header
  constexpr std::size_t kMostOfZlib = 1u << 31;
  if (packed.size() > kMostOfZlib || count > kMostOfZlib) return std::nullopt;
  std::vector<std::byte> bytes(count + 1);  // zlib wants room for more than nothing
  z_stream stream{};
  if (inflateInit2(&stream, kRaw) != Z_OK) return std::nullopt;
  stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  const int status = inflate(&stream, Z_FINISH);
  const bool is_whole = status == Z_STREAM_END && stream.total_out == count && stream.avail_in == 0;
  inflateEnd(&stream);
  if (!is_whole) return std::nullopt;
  bytes.resize(count);
  return bytes;
}

}  // namespace

Result<ZipArchive> ZipArchive::open(std::shared_ptr<const RandomAccess> file, const Limits& limits) {
  ZipArchive archive(std::move(file));
  if (auto entries = read_list(*archive.file_, limits)) {
    archive.entries_ = *std::move(entries);
    return archive;
  }
  archive.is_torn_ = true;
  archive.entries_ = walk_files(*archive.file_, limits);
  if (archive.entries_.empty()) return Error{ErrorCode::kInput, "no ZIP archive, or its first file is damaged"};
  return archive;
}

Result<std::vector<std::byte>> ZipArchive::read(const std::string& name, std::uintmax_t max_bytes) const {
  const auto refuse = [&](const std::string& what) { return Error{ErrorCode::kInput, "'" + name + "' " + what}; };
  const auto found = entries_.find(name);
  if (found == entries_.end()) return refuse("is not in the archive");
  const Entry& entry = found->second;
  if (entry.unpacked_bytes > max_bytes || entry.packed_bytes > max_bytes) {
    return refuse("has more bytes than the limit of " + std::to_string(max_bytes));
  }
  if ((entry.flags & kEncrypted) != 0) return refuse("is encrypted");
  if (entry.method != kStored && entry.method != kDeflated) {
    return refuse("is packed by method " + std::to_string(entry.method) + ", expected 0 (stored) or 8 (deflate)");
  }
  const auto header = read_file_header(*file_, entry.header_at);
  auto bytes = header ? bytes_at(*file_, header->bytes_at, entry.packed_bytes) : std::nullopt;
  if (bytes && entry.method == kDeflated) bytes = inflated(*bytes, static_cast<std::size_t>(entry.unpacked_bytes));
  if (!bytes || bytes->size() != entry.unpacked_bytes) return refuse("is damaged or cut off in the archive");
  const auto crc = crc32_z(crc32_z(0, nullptr, 0), reinterpret_cast<const Bytef*>(bytes->data()), bytes->size());
  if (crc != entry.crc) return refuse("is damaged: its check sum is wrong");
  return *std::move(bytes);
}

}  // namespace scanknit

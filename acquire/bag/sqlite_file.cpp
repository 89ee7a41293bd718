#include "acquire/bag/sqlite_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

constexpr std::string_view kSqliteMagic{"SQLite format 3\0", 16};
constexpr std::size_t kDatabaseHeader = 100;
constexpr std::uint8_t kInnerPage = 5, kLeafPage = 13;  // of a table
constexpr std::size_t kMostLevels = 20;                 // SQLite's own
constexpr std::size_t kMostColumns = 100;
constexpr std::uint64_t kMostTextBytes = 1u << 16;

/// Seven bits a byte, the highest first; the ninth byte has eight.
std::optional<std::uint64_t> take_varint(ByteReader& reader) {
  std::uint64_t value = 0;
  for (int i = 0; i < 9; ++i) {
    const auto byte = reader.big_endian<std::uint8_t>();
    if (!byte) return std::nullopt;
    if (i == 8) return value << 8 | *byte;
    value = value << 7 | (*byte & 0x7Fu);
    if ((*byte & 0x80u) == 0) return value;
  }
  return std::nullopt;
}

template <typename T>
std::optional<T> number_at(std::span<const std::byte> bytes, std::size_t at) {
  return at <= bytes.size() ? ByteReader(bytes.subspan(at)).big_endian<T>() : std::nullopt;
}

/// The length of what a serial type stands for.
std::uint64_t length_of_type(std::uint64_t type) {
  constexpr std::array<std::uint64_t, 12> kFixed = {0, 1, 2, 3, 4, 6, 8, 8, 0, 0, 0, 0};
  return type < kFixed.size() ? kFixed[type] : (type - 12) / 2;
}

SqliteColumn::Kind kind_of_type(std::uint64_t type) {
  using Kind = SqliteColumn::Kind;
  if (type == 0 || type == 10 || type == 11) return Kind::kNull;
  if (type == 7) return Kind::kReal;
  if (type < 12) return Kind::kInteger;
  return type % 2 == 0 ? Kind::kBlob : Kind::kText;
}

/// Big endian, in two's complement.
std::int64_t signed_of(std::span<const std::byte> bytes) {
  std::uint64_t value = !bytes.empty() && (bytes[0] & std::byte{0x80}) != std::byte{} ? ~std::uint64_t{0} : 0;
  for (const std::byte byte : bytes) value = value << 8 | std::to_integer<std::uint64_t>(byte);
  return static_cast<std::int64_t>(value);
}

/// The names in "CREATE TABLE t(a INTEGER PRIMARY KEY, b TEXT ...)".
std::vector<std::string> column_names(std::string_view sql) {
  std::vector<std::string> names;
  const auto begin = sql.find('(');
  if (begin == std::string_view::npos) return names;
  int depth = 0;
  bool is_before = true, is_within = false;  // a column's first word
  for (const char c : sql.substr(begin)) {
    if (c == '(') ++depth;
    if (c == ')' && --depth == 0) break;
    const bool is_of_name = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
    if (depth == 1 && c == ',') {
      is_before = true;
      is_within = false;
    } else if (is_of_name && is_before) {
      if (names.size() >= kMostColumns) break;
      names.emplace_back(1, c);
      is_before = false;
      is_within = true;
    } else if (is_of_name && is_within) {
      names.back() += c;
    } else {
      is_within = false;
    }
  }
  return names;
}

}  // namespace

std::optional<std::size_t> SqliteTable::column(std::string_view name) const {
  const auto found = std::find(columns.begin(), columns.end(), name);
  if (found == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns.begin());
}

bool is_sqlite(const RandomAccess& file) {
  std::array<std::byte, kSqliteMagic.size()> magic{};
  return file.read(0, magic) && std::equal(magic.begin(), magic.end(), kSqliteMagic.begin(),
                                           [](std::byte a, char b) { return a == static_cast<std::byte>(b); });
}

Result<SqliteFile> SqliteFile::open(std::unique_ptr<RandomAccess> file) {
  std::array<std::byte, kDatabaseHeader> header{};
  if (!is_sqlite(*file) || !file->read(0, header)) return Error{ErrorCode::kInput, "not a database of SQLite 3"};
  SqliteFile database(std::move(file));
  const std::uint32_t stated = number_at<std::uint16_t>(header, 16).value_or(0);
  database.page_size_ = stated == 1 ? 65536 : stated;
  const std::uint32_t reserved = std::to_integer<std::uint32_t>(header[20]);
  constexpr std::uint32_t kLeast = 512, kLeastUsable = 480;
  const bool is_power = (database.page_size_ & (database.page_size_ - 1)) == 0;
  if (database.page_size_ < kLeast || !is_power || database.page_size_ - reserved < kLeastUsable) {
    return Error{ErrorCode::kInput, "a damaged database of SQLite: pages of " + std::to_string(stated) + " bytes"};
  }
  if (number_at<std::uint32_t>(header, 56).value_or(0) > 1) {
    return Error{ErrorCode::kInput, "a database of SQLite whose texts are not UTF-8"};
  }
  database.usable_ = database.page_size_ - reserved;
  database.pages_ = database.file_->size() / database.page_size_;
  const std::uint32_t promised = number_at<std::uint32_t>(header, 28).value_or(0);
  if (database.pages_ < promised) {
    database.fault_ =
        "it is cut off after " + std::to_string(database.pages_) + " of " + std::to_string(promised) + " pages";
  }
  return database;
}

std::optional<SqliteTable> SqliteFile::find_table(std::string_view name) {
  constexpr std::size_t kType = 0, kName = 1, kRoot = 3, kSql = 4;
  constexpr std::uint32_t kSchemaRoot = 1;
  std::optional<SqliteTable> table;
  visit_rows(kSchemaRoot, [&](const SqliteRow& row) {
    if (row.columns.size() <= kSql || text(row, kType) != "table" || text(row, kName) != name) return true;
    const std::int64_t root = row.columns[kRoot].integer;
    const auto sql = text(row, kSql);
    if (!sql || root < 1 || static_cast<std::uint64_t>(root) > pages_) return true;
    table = SqliteTable{static_cast<std::uint32_t>(root), column_names(*sql)};
    return false;
  });
  return table;
}

void SqliteFile::note_fault(std::uint32_t page) {
  if (!fault_) fault_ = "its page " + std::to_string(page) + " is missing or damaged";
}

bool SqliteFile::enter(std::uint32_t number, std::vector<Step>& path, std::vector<bool>& is_visited) {
  Step step;
  step.number = number;
  step.page.resize(page_size_);
  const bool is_there = number >= 1 && number < is_visited.size() && !is_visited[number] && path.size() < kMostLevels &&
                        file_->read(page_begin(number), step.page);
  step.head = number == 1 ? kDatabaseHeader : 0;
  const auto type = number_at<std::uint8_t>(step.page, step.head).value_or(0);
  if (!is_there || (type != kInnerPage && type != kLeafPage)) {
    note_fault(number);
    return false;
  }
  is_visited[number] = true;
  step.is_leaf = type == kLeafPage;
  step.cells = number_at<std::uint16_t>(step.page, step.head + 3).value_or(0);
  path.push_back(std::move(step));
  return true;
}

// The page below an inner page's next cell: its number stands in front of the cell, the last one's in the header.
std::optional<std::uint32_t> SqliteFile::child_of(Step& step) const {
  const std::size_t cell = step.next++;
  if (cell == step.cells) return number_at<std::uint32_t>(step.page, step.head + 8);
  const auto at = number_at<std::uint16_t>(step.page, step.head + 12 + 2 * cell);
  return at ? number_at<std::uint32_t>(step.page, *at) : std::nullopt;
}

bool SqliteFile::next_row(std::vector<Step>& path, std::vector<bool>& is_visited, SqliteRow& row) {
  while (!path.empty()) {
    Step& step = path.back();
    if (step.next >= step.cells + (step.is_leaf ? 0 : 1)) {
      path.pop_back();
    } else if (!step.is_leaf) {
      const std::uint32_t number = step.number;
      const auto child = child_of(step);
      if (!child) note_fault(number);
      if (child) (void)enter(*child, path, is_visited);  // a fault is noted, and the next child is tried
    } else {
      const auto at = number_at<std::uint16_t>(step.page, step.head + 8 + 2 * step.next++);
      const bool is_row = at && parse_cell(step, *at, row) && (!step.last_id || row.id > *step.last_id);
      if (is_row) step.last_id = row.id;
      if (is_row && parse_columns(row)) return true;
      note_fault(step.number);
    }
  }
  return false;
}

// How much of a row is in its page is decided by the format's section 1.6.
bool SqliteFile::parse_cell(const Step& step, std::size_t at, SqliteRow& row) const {
  if (at >= usable_) return false;
  ByteReader reader(std::span(step.page).first(usable_).subspan(at));
  const auto size = take_varint(reader);
  const auto id = size ? take_varint(reader) : std::nullopt;
  if (!id || *size > file_->size()) return false;
  const std::uint64_t most = usable_ - 35;
  const std::uint64_t least = (usable_ - 12) * 32 / 255 - 23;
  std::uint64_t local = *size;
  if (*size > most) {
    local = least + (*size - least) % (usable_ - 4);
    if (local > most) local = least;
  }
  row.id = static_cast<std::int64_t>(*id);
  row.place = {page_begin(step.number) + at + reader.offset(), static_cast<std::uint32_t>(local), 0, *size};
  if (!reader.take(static_cast<std::size_t>(local))) return false;
  if (local == *size) return true;
  const auto overflow = reader.big_endian<std::uint32_t>();
  row.place.overflow = overflow.value_or(0);
  return row.place.overflow != 0;
}

bool SqliteFile::parse_columns(SqliteRow& row) const {
  row.columns.clear();
  constexpr std::size_t kFront = 512;  // a header of so many columns is shorter
  std::array<std::byte, kFront> buffer{};
  const auto front = std::span(buffer).first(static_cast<std::size_t>(std::min<std::uint64_t>(kFront, row.place.size)));
  if (!read(row.place, 0, front)) return false;
  ByteReader reader(front);
  const auto header = take_varint(reader);
  if (!header || *header > front.size()) return false;
  std::uint64_t offset = *header;
  while (reader.offset() < *header && row.columns.size() < kMostColumns) {
    const auto type = take_varint(reader);
    if (!type || reader.offset() > *header) return false;
    SqliteColumn column{kind_of_type(*type), offset, length_of_type(*type), *type == 9 ? 1 : 0};
    if (column.length > row.place.size - offset) return false;
    offset += column.length;
    // Behind what is long no table of ours has a number, and a chain would have to be followed for it.
    if (column.kind == SqliteColumn::Kind::kInteger && offset > row.place.local)
      column.kind = SqliteColumn::Kind::kNull;
    if (column.kind == SqliteColumn::Kind::kInteger && column.length > 0) {
      std::array<std::byte, 8> value{};
      const auto bytes = std::span(value).first(static_cast<std::size_t>(column.length));
      if (!read(row.place, column.offset, bytes)) return false;
      column.integer = signed_of(bytes);
    }
    row.columns.push_back(column);
  }
  return true;
}

// A page of a row's chain begins with the number of the next.
bool SqliteFile::read(const SqlitePlace& place, std::uint64_t offset, std::span<std::byte> to) const {
  if (offset > place.size || to.size() > place.size - offset) return false;
  std::uint64_t part_begin = 0;  // in the row
  std::uint64_t part_size = place.local, at = place.begin;
  std::uint32_t next = place.overflow;
  while (!to.empty()) {
    if (offset < part_begin + part_size) {
      const std::uint64_t skipped = offset - part_begin;
      const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(to.size(), part_size - skipped));
      if (!file_->read(at + skipped, to.first(count))) return false;
      to = to.subspan(count);
      offset += count;
      continue;
    }
    part_begin += part_size;
    part_size = usable_ - sizeof(std::uint32_t);
    std::array<std::byte, sizeof(std::uint32_t)> link{};
    if (next == 0 || !file_->read(page_begin(next), link)) return false;
    at = page_begin(next) + link.size();
    next = ByteReader(link).big_endian<std::uint32_t>().value_or(0);
  }
  return true;
}

std::optional<std::string> SqliteFile::text(const SqliteRow& row, std::size_t column) const {
  if (column >= row.columns.size()) return std::nullopt;
  const SqliteColumn& place = row.columns[column];
  const bool is_near = std::max(place.offset, place.length) <= kMostTextBytes;
  if (place.kind != SqliteColumn::Kind::kText || !is_near) return std::nullopt;
  std::string text(static_cast<std::size_t>(place.length), '\0');
  if (!read(row.place, place.offset, std::as_writable_bytes(std::span(text)))) return std::nullopt;
  return text;
}

}  // namespace scanknit

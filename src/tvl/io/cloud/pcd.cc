#include "tvl/io/cloud/pcd.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/io/cloud/byte_text.h"
#include "tvl/io/cloud/lzf.h"

namespace tvl {
namespace {

constexpr size_t kMostHeaderLines = 1000;      // eleven keys and comments
constexpr size_t kMostFields = 1000;           // a LidarScan message has some ten
constexpr size_t kMostCount = 65536;           // the longest descriptors have some thousands
constexpr size_t kMostSize = size_t{1} << 32;  // what a cloud of 32 bit counts can announce

struct Header {
  std::vector<PointField> fields;  // side by side, with their offsets
  size_t point_step = 0;
  size_t width = 0, height = 1;
  std::string viewpoint;  // as written, empty: the identity
  std::string data_kind;
  size_t data_offset = 0;  // of the first byte after the header
};

// One line of the header.
struct Entry {
  std::vector<std::string_view> words;  // without the key
  size_t line = 0;
};

using Entries = std::map<std::string, Entry, std::less<>>;

std::string AtLine(const std::string& source, size_t line) {
  return source + ":" + std::to_string(line);
}

// The lines up to and with DATA.
Entries ReadEntries(ByteLines* lines, const std::string& source) {
  constexpr std::array<std::string_view, 11> kKeys = {"VERSION", "FIELDS", "COLUMNS",  "SIZE",
                                                      "TYPE",    "COUNT",  "WIDTH",    "HEIGHT",
                                                      "POINTS",  "DATA",   "VIEWPOINT"};
  Entries entries;
  while (entries.count("DATA") == 0) {
    const std::optional<std::string_view> line = lines->Next();
    TVL_CHECK_INPUT(line.has_value() && lines->line() <= kMostHeaderLines)
        << AtLine(source, lines->line()) << ": the header ends without DATA: not a PCD file?";
    std::vector<std::string_view> words = Words(*line);
    if (words.empty() || words[0].front() == '#') continue;
    bool known = false;
    for (const std::string_view key : kKeys) known = known || key == words[0];
    TVL_CHECK_INPUT(known) << AtLine(source, lines->line()) << ": " << Quoted(words[0])
                           << " is no key of a PCD header: not a PCD file?";
    const std::string key(words[0] == "COLUMNS" ? "FIELDS" : words[0]);  // its name until 0.5
    words.erase(words.begin());
    const bool is_new = entries.emplace(key, Entry{std::move(words), lines->line()}).second;
    TVL_CHECK_INPUT(is_new) << AtLine(source, lines->line()) << ": " << key << " is there twice";
  }
  return entries;
}

NumberType TypeOf(std::string_view type, std::string_view size, const std::string& where) {
  const std::string key = std::string(type) + std::string(size);
  if (key == "I1") return NumberType::kInt8;
  if (key == "U1") return NumberType::kUint8;
  if (key == "I2") return NumberType::kInt16;
  if (key == "U2") return NumberType::kUint16;
  if (key == "I4") return NumberType::kInt32;
  if (key == "U4") return NumberType::kUint32;
  if (key == "I8") return NumberType::kInt64;
  if (key == "U8") return NumberType::kUint64;
  if (key == "F4") return NumberType::kFloat32;
  if (key == "F8") return NumberType::kFloat64;
  throw InputError(where + ": TYPE " + Quoted(type) + " of SIZE " + Quoted(size) +
                   ": want I or U of 1, 2, 4 or 8 bytes, or F of 4 or 8");
}

// The words of `key`, one a field; as many of `otherwise` where there is no such line.
Entry PerField(const Entries& entries, const char* key, std::string_view otherwise, size_t fields,
               const std::string& source) {
  const auto entry = entries.find(key);
  if (entry == entries.end()) return {std::vector<std::string_view>(fields, otherwise), 0};
  TVL_CHECK_INPUT(entry->second.words.size() == fields)
      << AtLine(source, entry->second.line) << ": " << key << ": want one word a field (" << fields
      << "), has " << entry->second.words.size();
  return entry->second;
}

void ReadFields(const Entries& entries, const std::string& source, Header* header) {
  const auto names = entries.find("FIELDS");
  TVL_CHECK_INPUT(names != entries.end() && !names->second.words.empty() &&
                  names->second.words.size() <= kMostFields)
      << source << ": the header has no FIELDS, or more than " << kMostFields;
  const size_t n = names->second.words.size();
  // What files of version 0.5 leave out.
  const Entry sizes = PerField(entries, "SIZE", "4", n, source);
  const Entry types = PerField(entries, "TYPE", "F", n, source);
  const Entry counts = PerField(entries, "COUNT", "1", n, source);
  for (size_t i = 0; i < n; ++i) {
    PointField field;
    field.name = std::string(names->second.words[i]);
    field.offset = header->point_step;
    field.type = TypeOf(types.words[i], sizes.words[i], AtLine(source, types.line));
    field.count = ParseCount(counts.words[i], kMostCount, AtLine(source, counts.line) + ": COUNT");
    TVL_CHECK_INPUT(field.count > 0) << AtLine(source, counts.line) << ": COUNT: want 1 or more";
    header->point_step += SizeOf(field.type) * field.count;
    header->fields.push_back(field);
  }
}

std::optional<size_t> OneCount(const Entries& entries, const char* key, const std::string& source) {
  const auto entry = entries.find(key);
  if (entry == entries.end()) return std::nullopt;
  const std::string where = AtLine(source, entry->second.line) + ": " + key;
  TVL_CHECK_INPUT(entry->second.words.size() == 1) << where << ": want one number";
  return ParseCount(entry->second.words[0], kMostSize, where);
}

void ReadSize(const Entries& entries, const std::string& source, Header* header) {
  const std::optional<size_t> points = OneCount(entries, "POINTS", source);
  const std::optional<size_t> width = OneCount(entries, "WIDTH", source);
  TVL_CHECK_INPUT(points || width) << source << ": the header has neither POINTS nor WIDTH";
  header->width = width ? *width : *points;
  header->height = width ? OneCount(entries, "HEIGHT", source).value_or(1) : 1;
  // 2^32 * 2^32 would overflow.
  const size_t most_rows = kMostSize / std::max<size_t>(header->width, 1);
  TVL_CHECK_INPUT(header->height <= most_rows &&
                  (!points || *points == header->width * header->height))
      << source << ": WIDTH " << header->width << " x HEIGHT " << header->height
      << " is not POINTS " << points.value_or(0);
}

std::string ViewpointOf(const Entries& entries, const std::string& source) {
  const auto entry = entries.find("VIEWPOINT");
  if (entry == entries.end()) return {};
  const std::string where = AtLine(source, entry->second.line) + ": VIEWPOINT";
  TVL_CHECK_INPUT(entry->second.words.size() == 7)
      << where << ": want 7 numbers (tx ty tz qw qx qy qz), has " << entry->second.words.size();
  std::string text;
  bool is_identity = true;
  for (size_t i = 0; i < 7; ++i) {
    const double value = ParseAnyNumber(entry->second.words[i], where);
    is_identity = is_identity && value == (i == 3 ? 1.0 : 0.0);
    text += " " + std::string(entry->second.words[i]);
  }
  return is_identity ? std::string() : text;
}

Header ReadHeader(ByteLines* lines, const std::string& source) {
  const Entries entries = ReadEntries(lines, source);
  Header header;
  ReadFields(entries, source, &header);
  ReadSize(entries, source, &header);
  header.viewpoint = ViewpointOf(entries, source);
  const Entry& data = entries.at("DATA");
  TVL_CHECK_INPUT(data.words.size() == 1)
      << AtLine(source, data.line) << ": DATA: want ascii, binary or binary_compressed";
  header.data_kind = std::string(data.words[0]);
  header.data_offset = lines->offset();
  return header;
}

PointTable TableOf(const Header& header, const uint8_t* data, size_t bytes) {
  PointTable table;
  table.fields = header.fields;
  table.width = header.width, table.height = header.height;
  table.point_step = header.point_step;
  table.row_step = header.width * header.point_step;
  table.data = data;
  table.bytes = bytes;
  return table;
}

RawScan DecodeAscii(const Header& header, ByteLines* lines, const std::string& source) {
  std::vector<std::string> names;
  std::vector<size_t> columns;  // of the first number of each field
  size_t width = 0;
  for (const PointField& field : header.fields) {
    names.push_back(field.name);
    columns.push_back(width);
    width += field.count;
  }
  const size_t points = header.width * header.height;
  std::vector<double> numbers;
  size_t rows = 0;
  while (const std::optional<std::string_view> line = lines->Next()) {
    const std::vector<std::string_view> words = Words(*line);
    if (words.empty()) continue;
    const std::string where = AtLine(source, lines->line());
    TVL_CHECK_INPUT(words.size() == width)
        << where << ": want " << width << " numbers, has " << words.size();
    TVL_CHECK_INPUT(++rows <= points)
        << where << ": more points than the " << points << " of the header";
    for (const size_t column : columns) numbers.push_back(ParseAnyNumber(words[column], where));
  }
  TVL_CHECK_INPUT(rows == points) << source << ": " << rows << " points, the header says " << points
                                  << ": cut off?";
  return DecodePoints(TableOfNumbers(names, numbers, header.width, header.height, source), source);
}

// Unpacked data hold one field after the other, each for all points; here they become records.
std::vector<uint8_t> Interleave(const Header& header, const std::vector<uint8_t>& by_field) {
  const size_t points = header.width * header.height;
  std::vector<uint8_t> records(by_field.size());
  const uint8_t* from = by_field.data();
  for (const PointField& field : header.fields) {
    const size_t size = SizeOf(field.type) * field.count;
    for (size_t i = 0; i < points; ++i, from += size) {
      std::copy(from, from + size, &records[i * header.point_step + field.offset]);
    }
  }
  return records;
}

RawScan DecodeCompressed(const Header& header, const uint8_t* data, size_t bytes,
                         const std::string& source) {
  const size_t at = header.data_offset;
  const size_t packed = LittleUint32At(data, bytes, at, source);
  const size_t unpacked = LittleUint32At(data, bytes, at + 4, source);
  TVL_CHECK_INPUT(packed <= bytes - at - 8)
      << source << ": byte " << at << ": " << packed << " compressed bytes are announced, "
      << bytes - at - 8 << " are there: cut off?";
  const size_t points = header.width * header.height;
  TVL_CHECK_INPUT(unpacked <= kMostCloudBytes && points <= unpacked &&
                  unpacked == points * header.point_step)
      << source << ": byte " << at + 4 << ": " << unpacked << " bytes are announced for " << points
      << " points of " << header.point_step << " bytes";
  const std::vector<uint8_t> records =
      Interleave(header, UnpackLzf(data + at + 8, packed, unpacked, source));
  return DecodePoints(TableOf(header, records.data(), records.size()), source);
}

}  // namespace

CloudRead ParsePcd(const uint8_t* data, size_t bytes, const std::string& source) {
  ByteLines lines(data, bytes);
  const Header header = ReadHeader(&lines, source);
  CloudRead read;
  if (!header.viewpoint.empty()) {
    read.notes.push_back("VIEWPOINT" + header.viewpoint + ": not applied, points are as stored");
  }
  if (header.data_kind == "ascii") {
    read.scan = DecodeAscii(header, &lines, source);
  } else if (header.data_kind == "binary") {
    const PointTable table = TableOf(header, data + header.data_offset, bytes - header.data_offset);
    read.scan = DecodePoints(table, source + ": byte " + std::to_string(header.data_offset));
  } else {
    TVL_CHECK_INPUT(header.data_kind == "binary_compressed")
        << AtLine(source, lines.line()) << ": DATA: want ascii, binary or binary_compressed, is "
        << Quoted(header.data_kind);
    read.scan = DecodeCompressed(header, data, bytes, source);
  }
  return read;
}

CloudRead ReadPcdScan(const std::string& path) {
  const std::vector<uint8_t> bytes = ReadFileBytes(path);
  return ParsePcd(bytes.data(), bytes.size(), path);
}

}  // namespace tvl

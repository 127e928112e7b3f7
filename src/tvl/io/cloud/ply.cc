#include "tvl/io/cloud/ply.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/io/cloud/byte_text.h"

namespace tvl {
namespace {

constexpr size_t kMostHeaderLines = 10000;      // some writers put their settings into comments
constexpr size_t kMostProperties = 1000;        // descriptors of Gaussian splats have some sixty
constexpr size_t kMostItems = size_t{1} << 32;  // more than any file has: the data will tell

struct Property {
  std::string name;
  NumberType type = NumberType::kFloat32;
  std::optional<NumberType> length_type;  // of a list
};

struct Element {
  std::string name;
  size_t count = 0;
  std::vector<Property> properties;

  bool HasLists() const {
    return std::any_of(properties.begin(), properties.end(),
                       [](const Property& p) { return p.length_type.has_value(); });
  }
  // Bytes of an item without lists.
  size_t Bytes() const {
    size_t bytes = 0;
    for (const Property& property : properties) bytes += SizeOf(property.type);
    return bytes;
  }
};

struct Header {
  bool is_ascii = false, is_big_endian = false;
  std::vector<Element> before;  // the vertices
  Element vertex;
};

std::string AtLine(const std::string& source, size_t line) {
  return source + ":" + std::to_string(line);
}

NumberType TypeOf(std::string_view word, const std::string& where) {
  if (word == "char" || word == "int8") return NumberType::kInt8;
  if (word == "uchar" || word == "uint8") return NumberType::kUint8;
  if (word == "short" || word == "int16") return NumberType::kInt16;
  if (word == "ushort" || word == "uint16") return NumberType::kUint16;
  if (word == "int" || word == "int32") return NumberType::kInt32;
  if (word == "uint" || word == "uint32") return NumberType::kUint32;
  if (word == "int64") return NumberType::kInt64;
  if (word == "uint64") return NumberType::kUint64;
  if (word == "float" || word == "float32") return NumberType::kFloat32;
  if (word == "double" || word == "float64") return NumberType::kFloat64;
  throw InputError(where + ": type of a property: " + Quoted(word));
}

Property ReadProperty(const std::vector<std::string_view>& words, const std::string& where) {
  Property property;
  const bool is_list = words.size() == 5 && words[1] == "list";
  TVL_CHECK_INPUT(is_list || words.size() == 3)
      << where << ": want `property TYPE NAME` or `property list TYPE TYPE NAME`";
  if (is_list) {
    property.length_type = TypeOf(words[2], where);
    TVL_CHECK_INPUT(property.length_type != NumberType::kFloat32 &&
                    property.length_type != NumberType::kFloat64)
        << where << ": the length of a list must be a whole number, is " << Quoted(words[2]);
  }
  property.type = TypeOf(words[words.size() - 2], where);
  property.name = std::string(words.back());
  constexpr std::string_view kPrefix = "scalar_";
  if (property.name.compare(0, kPrefix.size(), kPrefix) == 0) {
    property.name.erase(0, kPrefix.size());
  }
  return property;
}

void ReadFormat(const std::vector<std::string_view>& words, const std::string& where,
                Header* header) {
  const std::string_view format = words.size() == 3 ? words[1] : std::string_view();
  header->is_ascii = format == "ascii";
  header->is_big_endian = format == "binary_big_endian";
  TVL_CHECK_INPUT(header->is_ascii || header->is_big_endian || format == "binary_little_endian")
      << where
      << ": want `format ascii 1.0`, `binary_little_endian 1.0` or `binary_big_endian 1.0`";
}

// Elements up to and with `vertex`; those behind it are of no interest.
void SortElements(std::vector<Element> elements, const std::string& source, Header* header) {
  const auto vertex = std::find_if(elements.begin(), elements.end(),
                                   [](const Element& e) { return e.name == "vertex"; });
  TVL_CHECK_INPUT(vertex != elements.end()) << source << ": the header has no element vertex";
  for (auto element = elements.begin(); element <= vertex; ++element) {
    TVL_CHECK_INPUT(element->count == 0 || !element->properties.empty())
        << source << ": element " << Quoted(element->name) << " has no properties";
  }
  header->vertex = *vertex;
  elements.erase(vertex, elements.end());
  header->before = std::move(elements);
}

Header ReadHeader(ByteLines* lines, const std::string& source) {
  Header header;
  std::vector<Element> elements;
  bool has_format = false;
  TVL_CHECK_INPUT(lines->Next() == std::string_view("ply")) << source << ":1: not a PLY file";
  for (std::string_view key; key != "end_header";) {
    const std::optional<std::string_view> line = lines->Next();
    const std::string where = AtLine(source, lines->line());
    TVL_CHECK_INPUT(line.has_value() && lines->line() <= kMostHeaderLines)
        << where << ": the header does not end";
    const std::vector<std::string_view> words = Words(*line);
    key = words.empty() ? std::string_view() : words[0];
    if (key == "format") {
      ReadFormat(words, where, &header);
      has_format = true;
    } else if (key == "element") {
      TVL_CHECK_INPUT(words.size() == 3) << where << ": want `element NAME COUNT`";
      elements.push_back({std::string(words[1]), ParseCount(words[2], kMostItems, where), {}});
    } else if (key == "property") {
      TVL_CHECK_INPUT(!elements.empty() && elements.back().properties.size() < kMostProperties)
          << where << ": a property before any element, or more than " << kMostProperties;
      elements.back().properties.push_back(ReadProperty(words, where));
    } else {
      TVL_CHECK_INPUT(key.empty() || key == "comment" || key == "obj_info" || key == "end_header")
          << where << ": unknown key " << Quoted(key);
    }
  }
  TVL_CHECK_INPUT(has_format) << source << ": the header has no format";
  SortElements(std::move(elements), source, &header);
  return header;
}

// Steps through binary items and checks each step.
class Items {
 public:
  Items(const uint8_t* data, size_t bytes, size_t at, bool is_big_endian, const std::string& source)
      : data_(data), bytes_(bytes), at_(at), is_big_endian_(is_big_endian), source_(source) {}

  size_t at() const { return at_; }
  size_t left() const { return bytes_ - at_; }

  // Passes `count` pieces of `size` bytes and returns the first.
  const uint8_t* Pass(size_t count, size_t size) {
    TVL_CHECK_INPUT(count <= left() / size)
        << source_ << ": byte " << at_ << ": want " << count << " times " << size << " bytes, "
        << left() << " are left: cut off?";
    const uint8_t* piece = data_ + at_;
    at_ += count * size;
    return piece;
  }

  void PassList(const Property& property) {
    const size_t begin = at_;
    const uint8_t* length_bytes = Pass(1, SizeOf(*property.length_type));
    const double length = NumberAt(length_bytes, *property.length_type, is_big_endian_);
    TVL_CHECK_INPUT(length >= 0.0)
        << source_ << ": byte " << begin << ": list of length " << length;
    TVL_CHECK_INPUT(length <= static_cast<double>(left()))
        << source_ << ": byte " << begin << ": list of length " << length << ", " << left()
        << " bytes are left: cut off?";
    Pass(static_cast<size_t>(length), SizeOf(property.type));
  }

  void PassElement(const Element& element) {
    if (element.count == 0) return;
    if (!element.HasLists()) {
      Pass(element.count, element.Bytes());
      return;
    }
    // Each item has at least the length of one list, so that the bytes bound the loop.
    for (size_t i = 0; i < element.count; ++i) {
      for (const Property& property : element.properties) {
        if (property.length_type) {
          PassList(property);
        } else {
          Pass(1, SizeOf(property.type));
        }
      }
    }
  }

 private:
  const uint8_t* data_;
  size_t bytes_, at_;
  bool is_big_endian_;
  std::string source_;
};

// The table without data: the scalars of a vertex side by side.
PointTable ScalarTable(const Header& header) {
  PointTable table;
  for (const Property& property : header.vertex.properties) {
    if (property.length_type) continue;
    table.fields.push_back({property.name, table.point_step, property.type, 1});
    table.point_step += SizeOf(property.type);
  }
  table.width = header.vertex.count;
  table.big_endian = header.is_big_endian;
  return table;
}

RawScan DecodeBinary(const Header& header, const uint8_t* data, size_t bytes, size_t at,
                     const std::string& source) {
  Items items(data, bytes, at, header.is_big_endian, source);
  for (const Element& element : header.before) items.PassElement(element);
  PointTable table = ScalarTable(header);
  std::vector<uint8_t> scalars;  // where lists lie between them
  if (header.vertex.HasLists()) {
    for (size_t i = 0; i < header.vertex.count; ++i) {
      for (const Property& property : header.vertex.properties) {
        if (property.length_type) {
          items.PassList(property);
        } else {
          const size_t size = SizeOf(property.type);
          const uint8_t* number = items.Pass(1, size);
          scalars.insert(scalars.end(), number, number + size);
        }
      }
    }
    table.data = scalars.data(), table.bytes = scalars.size();
  } else {
    table.data = data + items.at(), table.bytes = items.left();
  }
  return DecodePoints(table, source + ": byte " + std::to_string(items.at()));
}

// The scalars of one vertex in ascii, appended to `numbers`.
void ReadAsciiVertex(const Element& vertex, std::string_view line, const std::string& where,
                     std::vector<double>* numbers) {
  const std::vector<std::string_view> words = Words(line);
  size_t next = 0;
  for (const Property& property : vertex.properties) {
    TVL_CHECK_INPUT(next < words.size()) << where << ": only " << words.size() << " numbers";
    if (property.length_type) {
      const size_t left = words.size() - next - 1;
      next += 1 + ParseCount(words[next], left, where + ": length of a list");
    } else {
      numbers->push_back(ParseAnyNumber(words[next++], where));
    }
  }
  TVL_CHECK_INPUT(next == words.size())
      << where << ": want " << next << " numbers, has " << words.size();
}

// Items are lines here, whatever is on them.
RawScan DecodeAscii(const Header& header, ByteLines* lines, const std::string& source) {
  const auto next = [&](const Element& element, size_t i) {
    std::optional<std::string_view> line = lines->Next();
    while (line && Words(*line).empty()) line = lines->Next();
    TVL_CHECK_INPUT(line.has_value())
        << AtLine(source, lines->line()) << ": the file ends after " << i << " of " << element.count
        << " lines of element " << Quoted(element.name) << ": cut off?";
    return *line;
  };
  for (const Element& element : header.before) {
    for (size_t i = 0; i < element.count; ++i) next(element, i);
  }
  std::vector<double> numbers;
  for (size_t i = 0; i < header.vertex.count; ++i) {
    const std::string_view line = next(header.vertex, i);
    ReadAsciiVertex(header.vertex, line, AtLine(source, lines->line()), &numbers);
  }
  std::vector<std::string> names;
  for (const PointField& field : ScalarTable(header).fields) names.push_back(field.name);
  return DecodePoints(TableOfNumbers(names, numbers, header.vertex.count, 1, source), source);
}

}  // namespace

CloudRead ParsePly(const uint8_t* data, size_t bytes, const std::string& source) {
  ByteLines lines(data, bytes);
  const Header header = ReadHeader(&lines, source);
  CloudRead read;
  read.scan = header.is_ascii ? DecodeAscii(header, &lines, source)
                              : DecodeBinary(header, data, bytes, lines.offset(), source);
  return read;
}

CloudRead ReadPlyScan(const std::string& path) {
  const std::vector<uint8_t> bytes = ReadFileBytes(path);
  return ParsePly(bytes.data(), bytes.size(), path);
}

}  // namespace tvl

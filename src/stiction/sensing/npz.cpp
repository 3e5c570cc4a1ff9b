#include "stiction/sensing/npz.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <string_view>
#include <vector>

#include "stiction/core/invalid_input.hpp"

namespace stiction::sensing {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are read as they lie in the file");

constexpr std::string_view kDirectoryEnd = "PK\x05\x06", kDirectoryEntry = "PK\x01\x02", kLocalHeader = "PK\x03\x04", kArray = "\x93NUMPY";

/// Bytes of an archive, of which every access is checked.
class Bytes {
 public:
  Bytes(const std::filesystem::path& file, std::string_view bytes) : file_(file), bytes_(bytes) {}

  [[noreturn]] void fail(const std::string& got) const {
    throw core::InvalidInput(fmt::format("{}: series: got {}, expected a file of numpy.savez with t, q and tau", file_.string(), got));
  }
  std::string_view take(std::size_t at, std::size_t count) const {
    if (at > bytes_.size() || count > bytes_.size() - at) fail("a damaged archive");
    return bytes_.substr(at, count);
  }
  template <class T>
  T number(std::size_t at) const {
    T out;
    std::memcpy(&out, take(at, sizeof(T)).data(), sizeof(T));
    return out;
  }
  std::string_view all() const { return bytes_; }

 private:
  const std::filesystem::path& file_;
  std::string_view bytes_;
};

/// The sizes of 'shape': (10, 6) or (10,); nothing where it has no or more than two axes.
std::optional<std::pair<Eigen::Index, Eigen::Index>> read_shape(std::string_view header) {
  const std::size_t begin = header.find('(', header.find("'shape'")), end = header.find(')', begin);
  if (begin == std::string_view::npos || end == std::string_view::npos) return std::nullopt;
  std::vector<Eigen::Index> sizes;
  for (std::size_t at = begin + 1; at < end;) {
    Eigen::Index size = 0;
    const auto read = std::from_chars(header.data() + at, header.data() + end, size);
    if (read.ec == std::errc()) sizes.push_back(size);
    at = std::min(header.find(',', at), end) + 1;
    while (at < end && header[at] == ' ') ++at;
  }
  if (sizes.empty() || sizes.size() > 2) return std::nullopt;
  return std::pair(sizes[0], sizes.size() == 2 ? sizes[1] : Eigen::Index{1});
}

template <class T>
Eigen::MatrixXd read_numbers(const Bytes& bytes, std::string_view data, Eigen::Index rows, Eigen::Index columns, bool by_column) {
  const auto count = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  if (data.size() != count * sizeof(T)) bytes.fail("a damaged archive");
  std::vector<T> numbers(count);
  std::memcpy(numbers.data(), data.data(), data.size());
  using RowMajor = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  using ColumnMajor = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;
  if (by_column) return Eigen::Map<const ColumnMajor>(numbers.data(), rows, columns).template cast<double>();
  return Eigen::Map<const RowMajor>(numbers.data(), rows, columns).template cast<double>();
}

void append_utf8(std::uint32_t point, std::string& out) {
  constexpr std::uint32_t kLow = 0x3F, kNext = 0x80;  // six bits of each byte after the first one
  const auto add = [&](std::uint32_t byte) { out.push_back(static_cast<char>(byte)); };
  if (point < 0x80) return add(point);
  if (point < 0x800) {
    add(0xC0 | (point >> 6));
  } else if (point < 0x10000) {
    add(0xE0 | (point >> 12));
    add(kNext | ((point >> 6) & kLow));
  } else {
    add(0xF0 | ((point >> 18) & 0x7));
    add(kNext | ((point >> 12) & kLow));
    add(kNext | ((point >> 6) & kLow));
  }
  add(kNext | (point & kLow));
}

/// Words of `length` code points of four bytes each, filled up with zeros.
std::vector<std::string> read_words(const Bytes& bytes, std::string_view data, std::size_t count, std::size_t length) {
  constexpr std::size_t kPoint = sizeof(std::uint32_t);
  if (length == 0 || data.size() / kPoint / length != count || data.size() != count * length * kPoint) bytes.fail("a damaged archive");
  std::vector<std::string> out(count);
  for (std::size_t i = 0; i < count * length; ++i) {
    std::uint32_t point = 0;
    std::memcpy(&point, data.data() + i * kPoint, kPoint);
    if (point != 0) append_utf8(point, out[i / length]);
  }
  return out;
}

/// N of a data type '<UN'; nothing where the type is another one.
std::optional<std::size_t> read_word_length(std::string_view header) {
  constexpr std::string_view kWords = "'<U";
  const std::size_t at = header.find(kWords);
  if (at == std::string_view::npos) return std::nullopt;
  std::size_t out = 0;
  const auto read = std::from_chars(header.data() + at + kWords.size(), header.data() + header.size(), out);
  return read.ec == std::errc() ? std::optional(out) : std::nullopt;
}

/// An .npy file: magic, version, length of the header, header as a literal of Python, numbers.
void read_array(const Bytes& bytes, const std::string& name, std::string_view file, NpzArrays& out) {
  constexpr std::size_t kVersion = 6;
  if (file.substr(0, kArray.size()) != kArray || file.size() < 12) bytes.fail(fmt::format("'{}', which is no array", name));
  std::uint32_t length = 0;
  const bool is_short = file[kVersion] == 1;
  std::memcpy(&length, file.data() + kVersion + 2, is_short ? 2 : 4);
  const std::size_t begin = kVersion + 2 + (is_short ? 2 : 4);
  if (begin + length > file.size()) bytes.fail("a damaged archive");
  const std::string_view header = file.substr(begin, length), data = file.substr(begin + length);
  const auto shape = read_shape(header);
  if (!shape) bytes.fail(fmt::format("'{}' with no or more than two axes", name));
  const bool by_column = header.find("'fortran_order': True") != std::string_view::npos;
  if (header.find("'<f8'") != std::string_view::npos) {
    out.numbers[name] = read_numbers<double>(bytes, data, shape->first, shape->second, by_column);
  } else if (header.find("'<f4'") != std::string_view::npos) {
    out.numbers[name] = read_numbers<float>(bytes, data, shape->first, shape->second, by_column);
  } else if (const auto word = read_word_length(header); word && shape->second == 1) {
    out.words[name] = read_words(bytes, data, static_cast<std::size_t>(shape->first), *word);
  } else {
    bytes.fail(fmt::format("'{}' of another type than float64, float32 and words", name));
  }
}

}  // namespace

NpzArrays read_npz(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::string content{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  const Bytes bytes(file, content);
  if (!stream.is_open()) bytes.fail("a file that cannot be read");
  const std::size_t end = bytes.all().rfind(kDirectoryEnd);
  if (end == std::string_view::npos) bytes.fail(content.empty() ? "an empty file" : "no archive");
  NpzArrays out;
  std::size_t at = bytes.number<std::uint32_t>(end + 16);
  for (int left = bytes.number<std::uint16_t>(end + 10); left > 0; --left) {
    if (bytes.take(at, 4) != kDirectoryEntry) bytes.fail("a damaged archive");
    const auto packed = bytes.number<std::uint32_t>(at + 20);
    const auto name_length = bytes.number<std::uint16_t>(at + 28);
    const std::size_t local = bytes.number<std::uint32_t>(at + 42);
    std::string name(bytes.take(at + 46, name_length));
    if (name.ends_with(".npy")) name.resize(name.size() - 4);
    if (bytes.number<std::uint16_t>(at + 10) != 0) bytes.fail(fmt::format("'{}', which is compressed", name));
    if (bytes.take(local, 4) != kLocalHeader) bytes.fail("a damaged archive");
    const std::size_t data = local + 30 + bytes.number<std::uint16_t>(local + 26) + bytes.number<std::uint16_t>(local + 28);
    read_array(bytes, name, bytes.take(data, packed), out);
    at += 46 + name_length + bytes.number<std::uint16_t>(at + 30) + bytes.number<std::uint16_t>(at + 32);
  }
  return out;
}

}  // namespace stiction::sensing

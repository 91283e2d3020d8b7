#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <list>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/format_error.h"
#include "formats/packed_file.h"
#include "preprocess/neutral.h"

/// The parts of messages between processes: arrays, texts, fields. A description calls the same
/// functions of a writer and of a reader (process/messages.cpp).
namespace rhoray::preprocess::message {

using formats::ArraySpec;
using formats::ElementType;
using formats::PackedFile;
using formats::PackedFileWriter;

/// Where the numbers of an array's elements lie: those of a row, or the element itself.
template <class T>
struct Row {
  using Number = T;
  static constexpr std::uint64_t width = 0;  ///< a plain list
};
template <class T, std::size_t N>
struct Row<std::array<T, N>> {
  using Number = T;
  static constexpr std::uint64_t width = N;
};
template <>
struct Row<CellKind> : Row<std::uint8_t> {};
template <>
struct Row<NeutralSurface::Region> : Row<std::array<double, 5>> {};
static_assert(sizeof(NeutralSurface::Region) == 5 * sizeof(double));

/// Sends what a description names. Gathers arrays first, then declares and writes them at once.
/// Empty arrays are left out.
class MessageWriter {
 public:
  /// The values must outlive this object.
  template <class List>
  void array(const std::string& name, const List& values) {
    add<typename List::value_type>(name, std::as_bytes(std::span(values)));
  }
  template <class T>
  void copy(const std::string& name, const std::vector<T>& values) {
    const auto bytes = std::as_bytes(std::span(values));
    add<T>(name, copies_.emplace_back(bytes.begin(), bytes.end()));
  }
  void add(const std::string& name, ElementType type, std::vector<std::uint64_t> shape,
           std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    specs_.push_back({.name = name, .type = type, .shape = std::move(shape), .alignment = 64});
    contents_.push_back(bytes);
  }
  /// A text ends at its first NUL.
  void text(const std::string& text) {
    joined_.insert(joined_.end(), text.c_str(), text.c_str() + std::strlen(text.c_str()) + 1);
  }
  void rest_of_texts(const std::vector<std::string>& texts) {
    for (const std::string& each : texts) text(each);
  }
  /// One text each: four numbers, whether it exists, and its path.
  void sources(const std::vector<SourceFile>& sources) {
    std::vector<std::string> texts;
    for (const SourceFile& s : sources)
      texts.push_back(
          concat(s.device, ' ', s.inode, ' ', s.bytes, ' ', s.changed_ns, ' ', s.exists ? 1 : 0, ' ', s.path.string()));
    counted_texts(texts);
  }
  void counted_texts(const std::vector<std::string>& texts) {
    text(concat(texts.size()));
    rest_of_texts(texts);
  }

  /// One text each: the label, a space and the name.
  void label_names(const formats::LabelNames& names) {
    std::vector<std::string> texts;
    for (const auto& [label, name] : names) texts.push_back(concat(label, ' ', name));
    counted_texts(texts);
  }

  /// A list of fields: values "<list>.0" ..., facts "<list>" [n, 2], names and units among the
  /// texts.
  void fields(const std::string& list, const std::vector<NeutralField>& fields, std::uint64_t) {
    std::vector<std::array<std::uint64_t, 2>> facts;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const NeutralField& field = fields[i];
      const auto components = static_cast<std::uint64_t>(field.component_count);
      facts.push_back({components, field.was_single_precision ? 1U : 0U});
      text(field.name);
      text(field.unit);
      label_names(field.label_names);
      add(concat(list, ".", i), ElementType::F64, {field.values.size() / components, components},
          std::as_bytes(std::span(field.values)));
    }
    copy(list, facts);
  }

  void write(const char* kind, int descriptor) {
    array("texts", joined_);
    formats::FileDescription description;
    description.kind = kind;
    PackedFileWriter writer(descriptor, description, specs_);
    for (std::size_t i = 0; i < specs_.size(); ++i) writer.write(specs_[i].name, 0, contents_[i]);
    writer.commit();
  }

 private:
  template <class T>
  void add(const std::string& name, std::span<const std::byte> bytes) {
    std::vector<std::uint64_t> shape{bytes.size() / sizeof(T)};
    if (Row<T>::width > 0) shape.push_back(Row<T>::width);
    add(name, formats::element_type_of<typename Row<T>::Number>(), std::move(shape), bytes);
  }

  std::vector<ArraySpec> specs_;
  std::vector<std::span<const std::byte>> contents_;
  std::list<std::vector<std::byte>> copies_;
  std::vector<std::uint8_t> joined_;
};

/// Receives what a MessageWriter sent, by the same description.
class MessageReader {
 public:
  MessageReader(const PackedFile& file, const char* kind) : file_(file) {
    if (file.description().kind != kind) formats::refuse(file.name(), "header", file.description().kind, kind);
    split_texts();
  }

  template <class List>
  void array(const std::string& name, List& values) const {
    using Element = typename List::value_type;
    constexpr std::uint64_t width = Row<Element>::width;
    values.clear();
    if (!file_.has(name)) return;
    const auto all = file_.array<typename Row<Element>::Number>(
        name, width == 0 ? std::vector<std::uint64_t>{0} : std::vector<std::uint64_t>{0, width});
    values.resize(all.size_bytes() / sizeof(Element));
    if (!all.empty()) std::memcpy(static_cast<void*>(values.data()), all.data(), all.size_bytes());
  }
  template <class T>
  void copy(const std::string& name, std::vector<T>& values) const {
    array(name, values);
  }
  void text(std::string& text) {
    if (next_ == texts_.size()) formats::refuse(file_.name(), "array 'texts'", "too few texts", "one for each name");
    text = texts_[next_++];
  }
  std::string next_text() {
    std::string result;
    text(result);
    return result;
  }
  void counted_texts(std::vector<std::string>& texts) {
    for (std::size_t count = next_count(); count != 0; --count) texts.push_back(next_text());
  }
  void sources(std::vector<SourceFile>& sources) {
    std::vector<std::string> texts;
    counted_texts(texts);
    for (const std::string& text : texts) {
      SourceFile& source = sources.emplace_back();
      int exists = 0;
      const char* at = text.data();
      const char* const end = at + text.size();
      const auto number = [&](auto& value) {
        const auto read = std::from_chars(at, end, value);
        expect(read.ec == std::errc() && read.ptr != end && *read.ptr == ' ', "array 'texts'", "no file that was read",
               "five numbers and a path");
        at = read.ptr + 1;
      };
      number(source.device), number(source.inode), number(source.bytes), number(source.changed_ns), number(exists);
      source.exists = exists != 0;
      source.path = std::string(at, end);
    }
  }
  void rest_of_texts(std::vector<std::string>& texts) {
    texts.assign(texts_.begin() + static_cast<std::ptrdiff_t>(next_), texts_.end());
    next_ = texts_.size();
  }

  void label_names(formats::LabelNames& names) {
    std::vector<std::string> texts;
    counted_texts(texts);
    expect(texts.size() <= formats::most_label_names, "array 'texts'", concat(texts.size(), " names of labels"),
           concat("at most ", formats::most_label_names));
    for (const std::string& text : texts) {
      int label = 0;
      const char* const end = text.data() + text.size();
      const auto read = std::from_chars(text.data(), end, label);
      const bool has_name =
          read.ec == std::errc() && read.ptr != end && *read.ptr == ' ' && formats::is_label_name({read.ptr + 1, end});
      expect(has_name, "array 'texts'", "no label with a name", "a number and a name");
      names[label] = std::string(read.ptr + 1, end);
    }
  }

  void fields(const std::string& list, std::vector<NeutralField>& fields, std::uint64_t owners) {
    std::vector<std::array<std::uint64_t, 2>> facts;
    array(list, facts);
    for (const auto& [components, single] : facts) {
      expect(components >= 1 && components <= 1024, list, "a field without usable components", "1 to 1024");
      const std::string values = concat(list, ".", fields.size());
      NeutralField& field = fields.emplace_back();
      text(field.name);
      text(field.unit);
      label_names(field.label_names);
      field.component_count = static_cast<int>(components);
      field.was_single_precision = single != 0;
      if (owners == 0) continue;
      const std::span<const double> all = file_.array<double>(values, {owners, components});
      field.values.assign(all.begin(), all.end());
    }
  }

  void expect(bool holds, std::string_view place, std::string_view found, std::string_view expected) const {
    if (!holds) formats::refuse(file_.name(), place, found, expected);
  }

 private:
  std::size_t next_count() {
    std::size_t count = 0;
    const std::string text = next_text();
    const auto read = std::from_chars(text.data(), text.data() + text.size(), count);
    expect(read.ec == std::errc() && count <= texts_.size(), "array 'texts'", "no count of names", "a count");
    return count;
  }

  void split_texts() {
    std::vector<std::uint8_t> joined;
    array("texts", joined);
    expect(joined.empty() || joined.back() == 0, "array 'texts'", "an unfinished text", "a NUL at its end");
    for (auto begin = joined.begin(); begin != joined.end();) {
      const auto end = std::find(begin, joined.end(), 0);
      texts_.emplace_back(begin, end);
      begin = end + 1;
    }
  }

  const PackedFile& file_;
  std::vector<std::string> texts_;
  std::size_t next_ = 0;
};

}  // namespace rhoray::preprocess::message

#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/import/vtk/xml_outline.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

/// The XML of an XDMF file, versions 2 and 3. Follows references within the document: elements with
/// an attribute Reference, and xi:include. Every refusal names the line of an element.
///
/// Source: XDMF Model and Format, xdmf.org. Where it is silent, VTK's two readers of XDMF decide.
class XdmfDocument {
 public:
  /// Refuses text that is not well-formed, other documents and other versions. Entities that the
  /// document declares are refused, not expanded.
  explicit XdmfDocument(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return file_.path(); }
  const XmlElement& root() const { return root_; }

  /// The children of that name, in order. Stands in for an include what it selects, and for a
  /// reference the element that it names.
  std::vector<const XmlElement*> children(const XmlElement& parent, std::string_view name) const;
  /// The first of them; null when there is none.
  const XmlElement* child(const XmlElement& parent, std::string_view name) const;

  /// The value of the first of these attributes that is there, in lower case: programs spell words
  /// in different ways, and versions 2 and 3 call the same attribute "TopologyType" and "Type".
  static std::string word(const XmlElement& element, std::initializer_list<std::string_view> attributes);

  /// The numbers of an attribute, such as "3 4 5"; nothing when it is missing. Refuses other text,
  /// and sizes whose product exceeds 2^62.
  std::optional<std::vector<std::uint64_t>> sizes(const XmlElement& element, std::string_view attribute) const;

  /// The text of an element without comments and without space at its ends.
  std::string_view text(const XmlElement& element) const;

  /// The path of a file that an element names. Refuses one that is missing, and one that is not in
  /// the folder of the XDMF file or below it.
  std::filesystem::path companion(const XmlElement& element, std::string_view name) const;

  [[noreturn]] void refuse(const XmlElement& element, std::string_view found, std::string_view expected,
                           ErrorCode error_code = ErrorCode::invalid) const;

 private:
  std::vector<const XmlElement*> selected(const XmlElement& element, std::string_view path) const;
  const XmlElement& resolved(const XmlElement& element) const;

  ForeignFile file_;
  XmlElement root_;
  mutable std::deque<std::string> texts_;  ///< without their comments
  mutable std::map<std::string, std::vector<const XmlElement*>, std::less<>> known_paths_;
  /// of elements, in all searches together; they take less than a second
  mutable std::uint64_t visits_left_ = 20'000'000;
};

}  // namespace rhoray::preprocess

#include "preprocess/import/xdmf/xdmf_document.h"

#include <algorithm>

#include "formats/base/bytes.h"
#include "formats/base/lower_case.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/xdmf/element_path.h"

namespace rhoray::preprocess {
namespace {

constexpr std::string_view white_space = " \t\r\n";

std::string_view trim(std::string_view text) {
  const std::size_t begin = std::min(text.find_first_not_of(white_space), text.size());
  return text.substr(begin, text.find_last_not_of(white_space) + 1 - begin);
}

/// True for xi:include, whatever its prefix: programs name its namespace in several ways.
bool is_include(const XmlElement& element) {
  return element.name == "include" || element.name.ends_with(":include");
}

void check_version(const XdmfDocument& document) {
  const std::string version = XdmfDocument::word(document.root(), {"Version"});
  if (!version.empty() && version.front() != '2' && version.front() != '3')
    document.refuse(document.root(), concat("version ", in_quotes(version)), "2.0 to 3.0", ErrorCode::unsupported);
}

}  // namespace

XdmfDocument::XdmfDocument(const std::filesystem::path& path) : file_(path) {
  if (file_.text().find("<!ENTITY") != std::string_view::npos)
    refuse_input(path, "document type", "entities that it declares", "none: they are not expanded",
                 ErrorCode::unsupported);
  std::size_t end = 0;
  std::optional<XmlElement> root = xml_outline(file_.text(), {}, end);
  if (!root) refuse_input(path, concat("byte ", end), "the end of XML that is well-formed", "elements that end");
  root_ = *std::move(root);
  if (root_.name != "Xdmf") refuse_input(path, "root element", in_quotes(root_.name), "Xdmf");
  check_version(*this);
}

void XdmfDocument::refuse(const XmlElement& element, std::string_view found, std::string_view expected,
                          ErrorCode error_code) const {
  const std::string_view before = file_.text().substr(
      0, static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, element.name.data() - file_.text().data())));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  refuse_input(path(), concat("line ", line, ", ", element.name), found, expected, error_code);
}

std::vector<const XmlElement*> XdmfDocument::selected(const XmlElement& element, std::string_view path) const {
  const auto known = known_paths_.find(path);
  if (known != known_paths_.end()) return known->second;
  const auto found = select_elements(root_, path, visits_left_);
  if (!found)
    refuse(element, concat("the path ", in_quotes(path)), "a path from the root such as /Xdmf/Domain/Grid[1]/Topology",
           ErrorCode::unsupported);
  return known_paths_.emplace(path, *found).first->second;
}

const XmlElement& XdmfDocument::resolved(const XmlElement& element) const {
  constexpr int most_steps = 16;
  const XmlElement* at = &element;
  for (int step = 0; step <= most_steps; ++step) {
    const std::string_view reference = at->attribute("Reference");
    if (reference.empty()) return *at;
    const std::optional<std::string> path = without_entities(reference == "XML" ? text(*at) : reference);
    const auto found = path ? selected(*at, *path) : std::vector<const XmlElement*>();
    if (found.empty() || found.front()->name != element.name)
      refuse(*at, concat("no ", element.name, " at ", in_quotes(path.value_or(std::string(text(*at))))),
             "the path of one");
    at = found.front();
  }
  refuse(element, "references that lead in a circle", "one that leads to data");
}

std::vector<const XmlElement*> XdmfDocument::children(const XmlElement& parent, std::string_view name) const {
  std::vector<const XmlElement*> result;
  const auto add = [&](const XmlElement& found) {
    const XmlElement& target = resolved(found);
    // Grids inside grids could multiply the document.
    if (name == "Grid" && (&target != &found || std::none_of(parent.children.begin(), parent.children.end(),
                                                             [&](const XmlElement& own) { return &own == &found; })))
      refuse(parent, "a reference to a Grid", "references to its parts", ErrorCode::unsupported);
    result.push_back(&target);
  };
  for (const XmlElement& child : parent.children) {
    if (child.name == name) add(child);
    if (!is_include(child)) continue;
    const std::string_view file = child.attribute("href"), path = child.attribute("xpointer");
    if (!file.empty() || path.empty())
      refuse(child, file.empty() ? "no xpointer" : concat("the file ", in_quotes(file)), "parts of the same file",
             ErrorCode::unsupported);
    const auto found = selected(child, path);
    if (found.empty()) refuse(child, concat("nothing at ", in_quotes(path)), "elements");
    for (const XmlElement* element : found)
      if (element->name == name) add(*element);
  }
  return result;
}

const XmlElement* XdmfDocument::child(const XmlElement& parent, std::string_view name) const {
  const auto found = children(parent, name);
  return found.empty() ? nullptr : found.front();
}

std::string XdmfDocument::word(const XmlElement& element, std::initializer_list<std::string_view> attributes) {
  for (const std::string_view name : attributes)
    if (const std::string_view value = element.attribute(name); !value.empty()) return lower_case(trim(value));
  return {};
}

std::optional<std::vector<std::uint64_t>> XdmfDocument::sizes(const XmlElement& element,
                                                              std::string_view attribute) const {
  constexpr std::uint64_t most = std::uint64_t{1} << 62;
  constexpr std::size_t most_axes = 32;  // as HDF5
  const std::string_view words = element.attribute(attribute);
  if (words.empty()) return std::nullopt;
  std::vector<std::uint64_t> sizes;
  std::optional<std::uint64_t> product = 1;
  for (std::size_t at = 0; (at = words.find_first_not_of(white_space, at)) != words.npos;) {
    const std::size_t end = std::min(words.find_first_of(white_space, at), words.size());
    const auto size = parse_number<std::uint64_t>(words.substr(at, end - at));
    if (!size || sizes.size() == most_axes)
      refuse(element, concat(attribute, " ", in_quotes(words)), "sizes, such as 3 4 5");
    sizes.push_back(*size);
    product = product ? checked_product({*product, *size}) : std::nullopt;
    at = end;
  }
  if (!product || *product > most || sizes.empty())
    refuse(element, concat(attribute, " ", in_quotes(words)), "sizes whose product fits in memory");
  return sizes;
}

std::string_view XdmfDocument::text(const XmlElement& element) const {
  constexpr std::string_view begin_comment = "<!--", end_comment = "-->";
  std::string_view rest = element.content;
  if (rest.find('<') == rest.npos) return trim(rest);
  std::string& whole = texts_.emplace_back();
  while (!rest.empty()) {
    const std::size_t begin = std::min(rest.find(begin_comment), rest.size());
    whole += rest.substr(0, begin);
    const std::size_t end = rest.find(end_comment, begin);
    rest = end == rest.npos ? std::string_view() : rest.substr(end + end_comment.size());
  }
  return trim(whole);
}

std::filesystem::path XdmfDocument::companion(const XmlElement& element, std::string_view name) const {
  const std::optional<std::string> decoded = without_entities(trim(name));
  const bool is_name = decoded && !decoded->empty() &&
                       std::none_of(decoded->begin(), decoded->end(), [](char c) { return c >= 0 && c < ' '; });
  if (!is_name) refuse(element, concat("the file name ", in_quotes(name)), "the name of a file");
  const std::filesystem::path folder = std::filesystem::absolute(path()).parent_path().lexically_normal();
  const std::filesystem::path within = (folder / *decoded).lexically_normal().lexically_relative(folder);
  // A file that comes from elsewhere must not make the program read any other.
  if (within.empty() || *within.begin() == "..")
    refuse(element, concat("the file ", in_quotes(*decoded)), "one in the folder of the XDMF file, or below it",
           ErrorCode::unsupported);
  const std::filesystem::path beside = path().parent_path() / within;
  if (!is_there(beside))
    refuse(element, concat("no file ", in_quotes(*decoded)), "each file beside it", ErrorCode::unreadable);
  return beside;
}

}  // namespace rhoray::preprocess

// Prints the catalogue as a table: every case by every method. Without argument as Markdown, with
// "csv" as CSV.
#include <iostream>
#include <string_view>

#include "tests/hard_cases/catalogue/trial.h"

namespace rhoray::tests {
namespace {

const char* name_of(Asked asked) {
  switch (asked) {
    case Asked::surface_of_grid:
      return "surface of a grid";
    case Asked::surface_of_mesh:
      return "surface of a mesh";
    case Asked::largest_value:
      break;
  }
  return "largest value";
}

/// Table cells are "wrong/queries". "(touches lost/all)" counts touches that a method without
/// proofs did not see. "-" marks a method that does not answer the query.
void print_markdown(std::ostream& out) {
  out << "| case | question | hits |";
  for (const NamedMethod& method : catalogue_methods()) out << ' ' << method.name << " |";
  out << "\n|---|---|---:|";
  for (std::size_t n = 0; n < catalogue_methods().size(); ++n) out << "---:|";
  out << '\n';
  for (const HardCase& hard_case : catalogue()) {
    Trial trial(hard_case);
    out << "| " << hard_case.id << " | " << name_of(hard_case.asked) << " | " << trial.hit_count() << " |";
    for (const NamedMethod& method : catalogue_methods()) {
      if (!method.answers(hard_case.asked)) {
        out << " - |";
        continue;
      }
      const Tally tally = trial.tally(method);
      out << ' ' << tally.wrong() << '/' << tally.queries;
      if (tally.touches > 0) out << " (touches " << tally.touches_lost << '/' << tally.touches << ')';
      out << " |";
    }
    out << std::endl;
  }
}

void print_csv(std::ostream& out) {
  out << "case,question,method,questions,right,missed,false_hits,wrong_place,touches,touches_lost\n";
  for (const HardCase& hard_case : catalogue()) {
    Trial trial(hard_case);
    for (const NamedMethod& method : catalogue_methods()) {
      if (!method.answers(hard_case.asked)) continue;
      const Tally tally = trial.tally(method);
      out << hard_case.id << ',' << name_of(hard_case.asked) << ',' << method.name << ',' << tally.queries << ','
          << tally.queries - tally.wrong() << ',' << tally.missed << ',' << tally.false_hits << ',' << tally.wrong_place
          << ',' << tally.touches << ',' << tally.touches_lost << std::endl;
    }
  }
}

}  // namespace
}  // namespace rhoray::tests

int main(int argc, char** argv) {
  if (argc == 1) {
    rhoray::tests::print_markdown(std::cout);
  } else if (argc == 2 && std::string_view(argv[1]) == "csv") {
    rhoray::tests::print_csv(std::cout);
  } else {
    std::cerr << "hard_cases_table: no argument for Markdown, or csv\n";
    return 2;
  }
  return 0;
}

#include "tools/analysis/table.h"

#include <gtest/gtest.h>

#include <ctime>

#include "formats/base/number_text.h"
#include "tools/analysis/measure.h"

namespace rhoray::tools {
namespace {

TEST(Table, keeps_every_digit_and_quotes_what_a_reader_would_split) {
  const Table table{"t",
                    "A title",
                    Json::object(),
                    {{{"name", "a,\"b\""}, {"n", 3}, {"x", 0.1}}, {{"name", "c"}, {"n", 4}, {"x", nullptr}}}};
  EXPECT_EQ(csv_of(table), "name,n,x\n\"a,\"\"b\"\"\",3,0.1\nc,4,\n");
  EXPECT_EQ(text_of(table), "A title\nname   n  x\na,\"b\"  3  0.1\nc      4  -\n");
  EXPECT_EQ(json_of(table)["rows"][1]["n"], 4);
}

TEST(Measure, takes_the_middle_of_repetitions) {
  const Spread odd = spread_of({3, 1, 2}), even = spread_of({4, 1, 2, 3});
  EXPECT_EQ(odd.median, 2);
  EXPECT_EQ(even.median, 2.5);
  EXPECT_EQ(even.smallest, 1);
  EXPECT_EQ(even.largest, 4);
}

TEST(Measure, writes_numbers_for_people) {
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(72089600), "72,089,600");
  EXPECT_EQ(bytes_text(1023), "1023 B");
  EXPECT_EQ(bytes_text(1536), "1.5 KiB");
  EXPECT_EQ(bytes_text(~std::uint64_t{0}), "16.0 EiB");
  EXPECT_EQ(rounded(0.125, 2), "0.12");
}

TEST(Measure, counts_the_memory_of_this_process) {
  EXPECT_GT(usage_so_far().peak_bytes, 1U << 20);
}

TEST(Measure, counts_the_cpu_time_of_this_process) {
  const double before_s = usage_so_far().cpu_s;
  const std::clock_t start = std::clock();  // CPU time too, from another system function
  while (std::clock() - start < CLOCKS_PER_SEC / 10) continue;
  EXPECT_GE(usage_so_far().cpu_s - before_s, 0.099);
}

}  // namespace
}  // namespace rhoray::tools

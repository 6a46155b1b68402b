#include "sim/scenarios/csv_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace knap {
namespace csv_text_test {

using ::testing::ElementsAre;

TEST(CsvText, WhatIsWrittenReadsBack) {
  for (const std::string text : {"", "plain", "a,b", "say \"so\"", "\"", ",", "tail,"}) {
    EXPECT_THAT(SplitCsvLine("x," + MakeCsvField(text) + ",y"), ElementsAre("x", text, "y"));
  }
  EXPECT_EQ(MakeCsvField("two\nlines"), "\"two lines\"") << "a record is one line";
}

TEST(CsvText, OddLines) {
  EXPECT_THAT(SplitCsvLine(""), ElementsAre(""));
  EXPECT_THAT(SplitCsvLine(",,"), ElementsAre("", "", ""));
  EXPECT_THAT(SplitCsvLine("\"never closed,1"), ElementsAre("never closed,1"));
}

TEST(CsvText, TablesLeaveOutHalfARecord) {
  const CsvTable table("loss,why\n1.5,\"deep, 68%\"\n-2e-3,\n,\n3.25,hal");
  ASSERT_EQ(table.size(), 3U);
  EXPECT_EQ(table.GetNumber(0, "loss"), 1.5);
  EXPECT_EQ(table.Get(0, "why"), "deep, 68%");
  EXPECT_EQ(table.GetNumber(1, "loss"), -2e-3);
  EXPECT_TRUE(std::isnan(table.GetNumber(2, "loss")));
  EXPECT_TRUE(std::isnan(table.GetNumber(0, "why")));
  EXPECT_TRUE(std::isnan(table.GetNumber(0, "gone")));
  EXPECT_EQ(CsvTable("").size(), 0U);
}

}  // namespace csv_text_test
}  // namespace knap

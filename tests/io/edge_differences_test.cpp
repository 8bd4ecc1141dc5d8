// Tables of differences, and what is wrong with them by line.
#include "mq/io/edge_differences.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/folder.h"
#include "mq/base/error.h"
#include "mq/io/atomic_file.h"
#include "mq/io/bytes.h"

namespace mq {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class EdgeTable : public FolderTest {
 protected:
  EdgeDifferences read(const std::string& text) const {
    write_file(folder / "wanted.csv", to_bytes(text));
    return read_edge_differences(folder / "wanted.csv");
  }
  void expect_refused(const std::string& text, const std::string& why) const {
    EXPECT_THAT([&] { read(text); }, ThrowsMessage<IoError>(AllOf(HasSubstr("wanted.csv"), HasSubstr(why)))) << text;
  }
};

TEST_F(EdgeTable, HoldsPairsOfTexels) {
  const EdgeDifferences table = read("column,row,to_column,to_row,value\n3,4,4,4,0.5\r\n\n 7 , 8, 7,9,-1e-3\n");
  EXPECT_EQ(table.at, EdgeDifferences::At::texels);
  EXPECT_EQ(table.channels, 1);
  ASSERT_EQ(table.pairs.size(), 2U);
  EXPECT_EQ(table.pairs[0].from, (EdgeDifferences::Place{0, 3, 4}));
  EXPECT_EQ(table.pairs[1].to, (EdgeDifferences::Place{0, 7, 9}));
  EXPECT_EQ(table.pairs[1].line, 4);
  EXPECT_EQ(table.values, (std::vector<double>{0.5, -1e-3}));
  EXPECT_EQ(table.words(table.pairs[0].from), "column 3, row 4");
}

TEST_F(EdgeTable, HoldsSeveralTexturesAndChannels) {
  const EdgeDifferences table = read("texture,column,row,to_texture,to_column,to_row,r,g,b\n1,2,3,4,5,6,0.1,0.2,0.3");
  EXPECT_EQ(table.pairs[0].from, (EdgeDifferences::Place{1, 2, 3}));
  EXPECT_EQ(table.pairs[0].to, (EdgeDifferences::Place{4, 5, 6}));
  EXPECT_EQ(table.channels, 3);
  EXPECT_EQ(table.values, (std::vector<double>{0.1, 0.2, 0.3}));
  EXPECT_EQ(table.words(table.pairs[0].from), "texture 1, column 2, row 3");
}

TEST_F(EdgeTable, IsReadAsSpreadsheetsWriteIt) {
  EXPECT_EQ(read("\xEF\xBB\xBFvertex,to_vertex,value\r\n5,9,0.25\r\n").pairs.size(), 1U);
  expect_refused("vertex,to_vertex,value\n1,2,1e300\n", "line 2: value: found \"1e300\", wanted a number of 1e+30 at most");
}

TEST_F(EdgeTable, HoldsPairsOfVertices) {
  const EdgeDifferences table = read("vertex,to_vertex,value\n5,9,0.25\n");
  EXPECT_EQ(table.at, EdgeDifferences::At::vertices);
  EXPECT_EQ(table.pairs[0].to, (EdgeDifferences::Place{9, 0, 0}));
  EXPECT_EQ(table.words(table.pairs[0].from), "vertex 5");
}

TEST_F(EdgeTable, IsRefusedByLine) {
  expect_refused("", "line 1: found \"\", wanted names of columns");
  expect_refused("1,2,3,4,0.5\n", "line 1: found \"1,2,3,4,0.5\", wanted names of columns");
  expect_refused("vertex,to_vertex\n1,2\n", "wanted names of columns");
  expect_refused("vertex,to_vertex,value\n", "has no pairs");
  expect_refused("vertex,to_vertex,value\n1,2\n", "line 2: found 2 numbers, wanted 3");
  expect_refused("vertex,to_vertex,value\n1,2,0\n1,two,0\n", "line 3: to_vertex: found \"two\", wanted a number of");
  expect_refused("vertex,to_vertex,value\n1,2,nan\n", "line 2: value: found \"nan\"");
  expect_refused("vertex,to_vertex,value\n1,2.5,0\n", "to_vertex: found 2.5, wanted a whole number");
  expect_refused("vertex,to_vertex,value\n-1,2,0\n", "vertex: found -1, wanted a whole number from 0");
  expect_refused("vertex,to_vertex,value\n1,1e12,0\n", "to_vertex: found 1000000000000, wanted");
}

}  // namespace
}  // namespace mq

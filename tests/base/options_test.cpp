#include "mq/base/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mq/base/error.h"

namespace mq {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using Words = std::vector<std::string>;

OptionTable small_table() {
  OptionTable table("filter", "Smooth or sharpen a texture.");
  table.add({.name = "mesh",
             .place = Option::Place::positional,
             .type = Option::Type::path,
             .required = true,
             .help = "the model"});
  table.add({.name = "texture",
             .place = Option::Place::positional,
             .type = Option::Type::path,
             .count = Option::Count::many,
             .help = "its pictures"});
  table.add({.name = "beta",
             .letter = 'b',
             .type = Option::Type::number,
             .default_value = "1",
             .least = 0,
             .most = 100,
             .group = "Filter",
             .help = "factor on the gradients"});
  table.add({.name = "alpha",
             .type = Option::Type::number,
             .default_value = "1e-3",
             .least = 0,
             .group = "Filter",
             .help = "the thesis' weight"});
  table.add({.name = "length",
             .type = Option::Type::length,
             .group = "Filter",
             .help = "a distance instead of a weight"});
  table.add({.name = "solver",
             .type = Option::Type::choice,
             .default_value = "direct",
             .choices = {"direct", "multigrid"},
             .help = "how the system is solved"});
  table.add({.name = "seed",
             .type = Option::Type::integer,
             .default_value = "0",
             .least = 0,
             .group = "Running",
             .help = "of everything random"});
  table.add(
      {.name = "quiet", .group = "Running", .help = "say nothing", .scope = Option::Scope::run});
  table.exclusive({"alpha", "length"});
  return table;
}

std::string error_of(const Words& words) {
  try {
    parse_arguments(small_table(), words).check();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(Options, ReadNamesValuesAndPlaces) {
  const OptionValues values = parse_arguments(
      small_table(), {"a.obj", "--beta=3", "b.png", "--solver", "multigrid", "c d.png", "--quiet"});
  values.check();
  EXPECT_EQ(values.text("mesh"), "a.obj");
  EXPECT_THAT(values.texts("texture"), ElementsAre("b.png", "c d.png"));
  EXPECT_EQ(values.number("beta"), 3);
  EXPECT_EQ(values.text("solver"), "multigrid");
  EXPECT_TRUE(values.flag("quiet"));
}

TEST(Options, StandAtTheirDefaultsUnlessGiven) {
  const OptionValues values = parse_arguments(small_table(), {"a.obj"});
  EXPECT_EQ(values.number("alpha"), 1e-3);
  EXPECT_EQ(values.integer("seed"), 0);
  EXPECT_FALSE(values.flag("quiet"));
  EXPECT_FALSE(values.given("beta"));
  EXPECT_FALSE(values.has("length"));
}

TEST(Options, HaveTheDefaultThatTheirTableWasTold) {
  OptionTable table("filter", "Smooth or sharpen a texture.");
  table.with_default("threads", "1");
  table.add({.name = "threads", .type = Option::Type::integer, .default_value = "0", .help = "how many"});
  EXPECT_EQ(OptionValues(table).integer("threads"), 1);
  EXPECT_FALSE(OptionValues(table).given("threads"));
  EXPECT_EQ(table.find("threads").default_value, "1");
}

TEST(Options, GivenReplaceTheDefaultOfTheirRival) {
  const OptionValues values = parse_arguments(small_table(), {"a.obj", "--length", "8tx"});
  EXPECT_FALSE(values.has("alpha"));
  EXPECT_EQ(values.text("length"), "8tx");
}

TEST(Options, TakeWordsAfterTwoHyphensAsPlaces) {
  const OptionValues values = parse_arguments(small_table(), {"-b", "2", "--", "--odd name.obj"});
  EXPECT_EQ(values.text("mesh"), "--odd name.obj");
  EXPECT_EQ(values.number("beta"), 2);
}

TEST(Options, RefuseWhatIsNotANumber) {
  for (const char* value : {"abc", "nan", "inf", "-inf", "", "1e999", "3x", "0x10", "1,5", " 1"})
    EXPECT_THAT(
        error_of({"a.obj", "--beta", value}),
        HasSubstr(std::string("--beta: found '") + value + "', wanted a number from 0 to 100"));
  EXPECT_THAT(error_of({"a.obj", "--seed", "1.5"}), HasSubstr("wanted a whole number at least 0"));
}

TEST(Options, RefuseNumbersOutOfRange) {
  EXPECT_THAT(error_of({"a.obj", "--beta", "-1"}), HasSubstr("--beta: found '-1'"));
  EXPECT_THAT(error_of({"a.obj", "--beta", "100.5"}), HasSubstr("from 0 to 100"));
  EXPECT_EQ(error_of({"a.obj", "--beta", "100"}), "");
  EXPECT_EQ(error_of({"a.obj", "--beta", "+2.5"}), "");
}

TEST(Options, SuggestTheNearestName) {
  EXPECT_THAT(error_of({"a.obj", "--betta", "3"}), HasSubstr("'--betta', did you mean '--beta'?"));
  EXPECT_THAT(error_of({"a.obj", "--lenght", "3"}), HasSubstr("did you mean '--length'?"));
  EXPECT_THAT(error_of({"a.obj", "--solver", "multigird"}), HasSubstr("did you mean 'multigrid'?"));
  EXPECT_THAT(error_of({"a.obj", "--xyzzy"}), Not(HasSubstr("did you mean")));
}

TEST(Options, RefuseContradictionsRepetitionsAndGaps) {
  EXPECT_THAT(error_of({"a.obj", "--alpha", "1", "--length", "2"}),
              HasSubstr("--alpha and --length contradict each other"));
  EXPECT_THAT(error_of({"a.obj", "--beta", "1", "--beta", "2"}), HasSubstr("given twice"));
  EXPECT_THAT(error_of({}), HasSubstr("MESH is missing"));
  EXPECT_THAT(error_of({"a.obj", "--beta"}), HasSubstr("--beta needs a value"));
  EXPECT_THAT(error_of({"a.obj", "--beta", "--quiet"}), HasSubstr("--beta needs a value"));
  EXPECT_THAT(error_of({"a.obj", "--length", "-1%"}), HasSubstr("wanted a length"));
  EXPECT_THAT(error_of({"a.obj", "--mesh", "b.obj"}), HasSubstr("by its place"));
  EXPECT_THAT(error_of({"a.obj", "-z"}), HasSubstr("no option '-z'"));
  EXPECT_THAT(error_of({"a.obj", "-b2"}), HasSubstr("two words"));
  EXPECT_THAT(error_of({"a.obj", "--quiet=maybe"}), HasSubstr("wanted true or false"));
}

TEST(Options, LetAFlagThatIsOffContradictNothing) {
  OptionTable table("x", "");
  table.add({.name = "a", .help = "a"}).add({.name = "b", .help = "b"}).exclusive({"a", "b"});
  EXPECT_NO_THROW(parse_arguments(table, {"--a", "--b=false"}).check());
  EXPECT_THROW(parse_arguments(table, {"--a", "--b"}).check(), InvalidInput);
}

TEST(Options, AreAtTheirDefaultOnceReset) {
  OptionValues values = parse_arguments(small_table(), {"a.obj", "--beta", "3"});
  values.reset("beta");
  EXPECT_FALSE(values.given("beta"));
  EXPECT_EQ(values.text("beta"), parse_arguments(small_table(), {"a.obj"}).text("beta"));
  EXPECT_THROW(values.reset("betta"), InvalidInput);
}

TEST(Options, RefuseATableWhoseDefaultIsOutOfRange) {
  OptionTable table("x", "");
  EXPECT_THROW(
      table.add({.name = "n", .type = Option::Type::number, .default_value = "2", .most = 1}),
      InvalidInput);
}

TEST(Options, AreAllNamedInTheCompleteHelpWithDefaultAndRange) {
  const OptionTable table = small_table();
  const std::string help = help_text(table, HelpDetail::complete);
  for (const Option& option : table.options()) EXPECT_THAT(help, HasSubstr(display_name(option)));
  EXPECT_THAT(help, HasSubstr("[from 0 to 100, default 1]"));
  EXPECT_THAT(help, HasSubstr("usage: marquetry filter MESH [TEXTURE...] [options]"));
  for (std::size_t begin = 0; begin < help.size();) {
    const std::size_t end = help.find('\n', begin);
    EXPECT_LE(end - begin, 80U) << help.substr(begin, end - begin);
    begin = end + 1;
  }
}

TEST(Options, LeaveTheGroupRunningOutOfTheBriefHelp) {
  const std::string help = help_text(small_table(), HelpDetail::brief);
  EXPECT_THAT(help, HasSubstr("--beta"));
  EXPECT_THAT(help, Not(HasSubstr("--quiet")));
}

TEST(Options, KeepUnitsAndDefaultsInTheBriefHelp) {
  OptionTable table("filter", "Smooth or sharpen a texture.");
  table.add({.name = "radius",
             .type = Option::Type::number,
             .default_value = "2",
             .unit = "texels",
             .least = 0,
             .help = "how far"});
  table.add({.name = "angle", .type = Option::Type::number, .unit = "degrees", .help = "how steep"});
  const std::string help = help_text(table, HelpDetail::brief);
  EXPECT_THAT(help, HasSubstr("how far [in texels, default 2]\n"));
  EXPECT_THAT(help, HasSubstr("how steep [in degrees]\n"));
}

TEST(Nearest, CountsInsertionsRemovalsReplacementsAndSwaps) {
  EXPECT_EQ(nearest("fliter", {"filter", "fill"}), "filter");
  EXPECT_EQ(nearest("insp", {"inspect", "render"}), "inspect");
  EXPECT_EQ(nearest("chek", {"check"}), "check");
  EXPECT_EQ(nearest("zzzzzz", {"check"}), "");
}

}  // namespace
}  // namespace mq

#include "io/plies_csv.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "geometry/error.h"
#include "tests/temporary_directory.h"

namespace afptraj {
namespace {

const std::string header = "ply,x,y,z,dx,dy,dz\n";

PliesFile read(const std::string& content) {
  const test::TemporaryDirectory directory;
  return read_plies_file(directory.write("plies.csv", content));
}

TEST(PliesCsv, ReadsPliesInOrder) {
  const auto plies = read(
                         "# a comment\n"
                         "ply,x,y,z,dx,dy,dz,start\n"
                         "\n"
                         "P1,1,2,3,1,0,0,\n"
                         "P1,4.5,-5e1,+6,0,2,0,1\n"
                         "  # another\n"
                         "P0,7,8,9,0,0,-1,0\n")
                         .plies;
  ASSERT_EQ(plies.size(), 2u);
  EXPECT_EQ(plies[0].name, "P1");
  ASSERT_EQ(plies[0].points.size(), 2u);
  EXPECT_EQ(plies[0].start, 1u);
  EXPECT_EQ(plies[0].points[1].position, Vec3(4.5, -50, 6));
  EXPECT_EQ(plies[0].points[1].direction, Vec3(0, 2, 0));
  EXPECT_EQ(plies[0].points[0].line, 4);
  EXPECT_EQ(plies[1].name, "P0");
  EXPECT_EQ(plies[1].start, 0u);
  EXPECT_EQ(plies[1].points[0].line, 7);
}

// The same table however it is spelled.
TEST(PliesCsv, AcceptsEverySpellingOfATable) {
  const std::string row = "A,1,2,3,4,5,6";
  for (const std::string& text : {
           header + row + "\n", header + row,                     // with and without the last line end
           "\xef\xbb\xbf" + header + row + "\n",                  // byte order mark
           std::string("ply,x,y,z,dx,dy,dz\r\n") + row + "\r\n",  // CRLF
           std::string("ply,x,y,z,dx,dy,dz\r") + row + "\r",      // CR
           std::string("\"ply\",\"x\",y,z,dx,dy,dz\n\"A\",\"1\",2,3,4,5,6\n"),  // quotes
           std::string("z,dz,dy,dx,y,x,ply\n3,6,5,4,2,1,A\n"),                  // another order
           std::string("PLY, X ,Y,Z,dX,dY,dZ\nA, 1 ,2,3,4,5,6\n"),              // case and blanks
       }) {
    const auto plies = read(text).plies;
    ASSERT_EQ(plies.size(), 1u) << text;
    EXPECT_EQ(plies[0].name, "A") << text;
    EXPECT_EQ(plies[0].points[0].position, Vec3(1, 2, 3)) << text;
    EXPECT_EQ(plies[0].points[0].direction, Vec3(4, 5, 6)) << text;
  }
}

TEST(PliesCsv, QuotedFieldsHoldAnything) {
  const auto plies = read(header + "\"a,\"\"b\"\"\nc\",1,2,3,1,0,0\n\"#1\",1,2,3,1,0,0\n").plies;
  ASSERT_EQ(plies.size(), 2u);
  EXPECT_EQ(plies[0].name, "a,\"b\"\nc");
  EXPECT_EQ(plies[1].name, "#1");
  EXPECT_EQ(plies[1].points[0].line, 4);  // the quoted line end counts
}

TEST(PliesCsv, WarnsOfUnusedColumns) {
  const auto file = read("ply,x,y,z,dx,dy,dz,strat\nA,1,2,3,1,0,0,1\n");
  ASSERT_EQ(file.warnings.size(), 1u);
  EXPECT_NE(file.warnings[0].find("'strat' is not used; did you mean 'start'?"), std::string::npos)
      << file.warnings[0];
}

struct Defect {
  const char* name;
  std::string content;
  std::string where;    // what stands after the file's name
  std::string message;  // words of the message
  ErrorCode code = ErrorCode::bad_input;
};

class PliesCsvDefect : public testing::TestWithParam<Defect> {};

// Every defect is refused for its own reason, in its own line.
TEST_P(PliesCsvDefect, IsNamedWithItsLine) {
  const test::TemporaryDirectory directory;
  const std::string path = directory.write("plies.csv", GetParam().content);
  try {
    read_plies_file(path);
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), GetParam().code);
    EXPECT_EQ(e.where(), path + GetParam().where);
    EXPECT_NE(std::string(e.what()).find(GetParam().message), std::string::npos) << e.what();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    EXPECT_NE(std::string(e.what()).find_first_of(";("), std::string::npos) << "says no fix: " << e.what();
  }
}

using namespace std::string_literals;
INSTANTIATE_TEST_SUITE_P(
    Table, PliesCsvDefect,
    testing::Values(
        Defect{"Empty", "", "", "is empty"}, Defect{"Blank", " \n\n", "", "is empty"},
        Defect{"CommentsOnly", "# nothing\n", "", "is empty"}, Defect{"HeaderOnly", header, "", "no rows"},
        Defect{"Semicolons", "ply;x;y;z;dx;dy;dz\nA;1;2;3;1;0;0\n", ":1", "separated by semicolons"},
        Defect{"Tabs", "ply\tx\ty\tz\tdx\tdy\tdz\n", ":1", "separated by tabs"},
        Defect{"MissingColumn", "ply,x,y,z,dx,dy\nA,1,2,3,1,0\n", ":1",
               "column 'dz' is missing: the header has ply,x,y,z,dx,dy"},
        Defect{"MisspeltColumn", "ply,x,y,z,dx,dy,dzz\nA,1,2,3,1,0,0\n", ":1", "rename 'dzz' to 'dz'"},
        Defect{"DuplicateColumn", "ply,x,y,z,dx,dy,dz,x\nA,1,2,3,1,0,0,1\n", ":1", "column 'x' stands twice"},
        Defect{"NamelessColumn", "ply,x,y,z,dx,dy,dz,\nA,1,2,3,1,0,0,\n", ":1", "column 8 has no name"},
        Defect{"ShortRow", header + "A,1,2,3,1,0\n", ":2", "has 6 fields, the header 7"},
        Defect{"LongRow", header + "A,1,5,2,3,1,0,0\n", ":2", "has 8 fields, the header 7"},
        Defect{"OpenQuote", header + "A,1,2,3,1,0,0\n\"B,1,2,3\n,1,0,0\n", ":3", "never closed"},
        Defect{"TextAfterQuote", header + "\"A\"B,1,2,3,1,0,0\n", ":2", "goes on after its closing quote"},
        Defect{"QuoteInside", header + "A\"B,1,2,3,1,0,0\n", ":2", "has a quote inside"},
        Defect{"DecimalComma", header + "A,\"12,5\",2,3,1,0,0\n", ":2",
               "column 'x': '12,5' has a decimal comma; write 12.5"},
        Defect{"Word", header + "A,1,two,3,1,0,0\n", ":2", "column 'y': 'two' is not a number"},
        Defect{"EmptyNumber", header + "A,1,2,,1,0,0\n", ":2", "column 'z': is empty"},
        Defect{"Nan", header + "A,1,2,3,nan,0,0\n", ":2", "column 'dx': 'nan' is not a finite number"},
        Defect{"Infinity", header + "A,1,-inf,3,1,0,0\n", ":2", "column 'y': '-inf' is not a finite number"},
        Defect{"Overflow", header + "A,1e999,2,3,1,0,0\n", ":2",
               "column 'x': '1e999' is not a finite number"},
        Defect{"OutOfRange", header + "A,1,2,3e12,1,0,0\n", ":2", "column 'z': '3e12' is out of range"},
        Defect{"ZeroDirection", header + "A,1,2,3,1,0,0\nA,1,2,3,0,0,-0\n", ":3",
               "the direction (columns dx, dy, dz) is zero"},
        Defect{"EmptyName", header + " ,1,2,3,1,0,0\n", ":2", "column 'ply': is empty"},
        Defect{"PlyAgain", header + "A,1,2,3,1,0,0\nB,1,2,3,1,0,0\nA,1,2,3,1,0,0\n", ":4",
               "ply 'A' appears again after ply 'B'"},
        Defect{"StartTwice", "ply,x,y,z,dx,dy,dz,start\nA,1,2,3,1,0,0,1\nA,1,2,3,1,0,0,1\n", ":3",
               "start on line 2 already"},
        Defect{"StartNotAFlag", "ply,x,y,z,dx,dy,dz,start\nA,1,2,3,1,0,0,yes\n", ":2",
               "column 'start': 'yes' is neither 0 nor 1"},
        Defect{"Nul", header + "A,1,2,3,1,0,0\n\0"s, ":3", "NUL byte"},
        Defect{"Utf8", header + "\xc3(,1,2,3,1,0,0\n", ":2", "not valid UTF-8"},
        Defect{"Utf8Overlong", header + "\xc0\xaf,1,2,3,1,0,0\n", ":2", "not valid UTF-8"},
        Defect{"Utf16", "\xff\xfep\0l\0y\0"s, "", "UTF-16"},
        Defect{"Png", "\x89PNG\r\n\x1a\n", "", "looks like a PNG"},
        Defect{"Zip", "PK\x03\x04xxxx", "", "spreadsheet"},
        Defect{"Step", "ISO-10303-21;\nHEADER;\n", "", "looks like a STEP file"}),
    [](const auto& info) { return info.param.name; });

TEST(PliesCsv, RefusesWhatIsNoReadableFile) {
  const test::TemporaryDirectory directory;
  const auto message_of = [](const std::string& path) -> std::string {
    try {
      read_plies_file(path);
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::bad_input);
      EXPECT_EQ(e.where(), path.empty() ? "''" : path);
      return e.what();
    }
    return "accepted";
  };
  EXPECT_NE(message_of((directory / "absent.csv").string()).find("no such file"), std::string::npos);
  EXPECT_NE(message_of(directory.path().string()).find("is a directory"), std::string::npos);
  EXPECT_NE(message_of("/dev/zero").find("device or pipe"), std::string::npos);
  EXPECT_NE(message_of("").find("name a file"), std::string::npos);
  const std::string pipe = (directory / "pipe").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_NE(message_of(pipe).find("device or pipe"), std::string::npos);  // and does not wait for a writer
}

TEST(PliesCsv, LimitsPlies) {
  std::string text = header;
  for (int i = 0; i <= 10000; ++i) text += "P" + std::to_string(i) + ",1,2,3,1,0,0\n";
  try {
    read(text);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::resource_limit);
  }
}

}  // namespace
}  // namespace afptraj

"""The structure checks themselves: each rule must report what breaks it and nothing else."""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "scripts"))
from structure import functions, includes, sources, words  # noqa: E402


def names_and_lines(code):
    return [(f.name, f.lines) for f in functions.functions("a.cc", code)]


class FunctionLengths(unittest.TestCase):
    def test_counts_from_signature_to_closing_brace(self):
        code = "namespace a {\n\n// comment {\nint Add(int a,\n        int b) {\n  return a + b;\n}\n}\n"
        self.assertEqual(names_and_lines(code), [("Add", 4)])

    def test_lambdas_and_blocks_belong_to_the_function_around_them(self):
        code = "void F() {\n  auto g = [](int x) {\n    if (x) { return 1; }\n    return 2;\n  };\n  g(1);\n}\n"
        self.assertEqual(names_and_lines(code), [("F", 7)])

    def test_members_constructors_and_operators(self):
        code = """
template <typename T = int>
class A final : public B<int> {
 public:
  A() : a_{1}, b_(2), c_{3} {
    Init();
  }
  ~A() = default;
  A& operator=(const A&) { return *this; }
  bool operator()(int x = 3) const noexcept { return x == 3; }
  int a_{0};
  std::function<void(int)> f_{nullptr};
  enum class Kind { kOne, kTwo };
  struct Inner {
    double Value() const {
      return 1.0;
    }
  };
};
"""
        self.assertEqual(names_and_lines(code), [
            ("A", 3), ("operator=", 1), ("operator()", 1), ("Value", 3)])

    def test_initialisers_are_no_functions(self):
        code = "const int kA[] = {1, 2};\nconst Foo kB = Foo(1, {2, 3});\nconst Foo kC{Bar(1)};\n"
        self.assertEqual(names_and_lines(code), [])

    def test_strings_and_digit_separators_do_not_confuse(self):
        code = 'int F() {\n  auto s = "}{"; char c = \'{\'; int n = 1\'000; auto r = R"(}})";\n  return n;\n}\nint G() { return 1; }\n'
        self.assertEqual(names_and_lines(code), [("F", 4), ("G", 1)])

    def test_trailing_return_types_and_tests(self):
        code = "auto F(int a) -> std::vector<int> {\n  return {a};\n}\nTEST(Suite, Case) {\n}\n"
        self.assertEqual(names_and_lines(code), [("F", 3), ("Suite.Case", 2)])


class Includes(unittest.TestCase):
    def errors(self, path, text):
        return includes.direction_errors({path: text}, sources.is_test)

    def test_down_is_allowed_up_is_not(self):
        self.assertEqual(self.errors("src/tvl/vision/a.cc", '#include "tvl/base/check.h"\n'), [])
        self.assertEqual(len(self.errors("src/tvl/base/a.cc", '#include "tvl/vision/a.h"\n')), 1)

    def test_siblings_never_include_each_other(self):
        self.assertEqual(len(self.errors("src/tvl/odometry/a.cc", '#include "tvl/mapping/a.h"\n')), 1)
        self.assertEqual(self.errors("src/tvl/registration/a.cc", '#include "tvl/factors/a.h"\n'), [])

    def test_leaves(self):
        self.assertEqual(self.errors("src/tvl/sim/a.cc", '#include "tvl/io/a.h"\n'), [])
        self.assertEqual(len(self.errors("src/tvl/io/a.cc", '#include "tvl/sim/a.h"\n')), 1)

    def test_tests_may_include_anything_but_sources_no_test_helper(self):
        self.assertEqual(self.errors("src/tvl/base/a_test.cc", '#include "tvl/cli/a.h"\n'), [])
        self.assertEqual(
            len(self.errors("src/tvl/vision/a.cc", '#include "tvl/geometry/rigid3_matchers.h"\n')), 1)

    def test_unknown_folder(self):
        self.assertEqual(len(self.errors("src/tvl/misc/a.cc", "")), 1)

    def test_cycles(self):
        self.assertEqual(includes.cycles({"a": ["b"], "b": ["c"], "c": []}), [])
        self.assertEqual(includes.cycles({"a": ["b"], "b": ["c"], "c": ["a"]}), [["a", "b", "c", "a"]])


class Words(unittest.TestCase):
    def test_machine_paths_and_leftovers(self):
        for line in ("see /wo" "rk/data", "in /t" "mp/x", "// TO" "DO later", "  std::abort();",
                     "// x = Foo(a, b);", "../sha" "red/data"):
            self.assertEqual(len(words.errors("src/tvl/base/a.cc", line)), 1, line)

    def test_ordinary_text_passes(self):
        for line in ("// Rotates about p x z (see Eq. 2);", "net/wo" "rk/load", "static_assert(true);",
                     "// Throws InputError naming the field."):
            self.assertEqual(words.errors("src/tvl/base/a.cc", line), [], line)


if __name__ == "__main__":
    unittest.main()

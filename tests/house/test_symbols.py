"""The built library asks the system for nothing that prints, or that ends the process."""

import os
import re
import subprocess
import unittest

# By what the linker would look for: C, its checked variants, and C++. Not __assert_fail, which builds with assertions have.
FORBIDDEN = re.compile(
    r"^(abort|_?exit|_Exit|quick_exit|raise|kill|_ZSt(4cout|4cerr|4clog|5wcout)|stdout|stderr"
    r"|puts|fputs|fputc|putchar|putc|perror|write|fwrite|fwrite_unlocked|syslog|pthread_exit"
    r"|(__)?v?f?d?printf(_chk)?)(@.*)?$"
)
# A thread that still runs ends the process when it is destroyed: the standard's own rule, in the one home of threads.
TERMINATES = "_ZSt9terminatev"
# Clang's way to say what g++ says in its tables: an exception that leaves what may not throw.
CLANG_TERMINATES = "__clang_call_terminate"


def symbols_of(library, kind):
    """(object, symbol) for each symbol of a kind: U, left to others; W, there, and maybe elsewhere too."""
    lines = subprocess.run(["nm", "-A", library], capture_output=True, text=True, check=True).stdout.splitlines()
    found = [re.match(rf".*:([^:]+):[0-9a-f]*\s+{kind}\s+(\S+)$", line) for line in lines]
    return [match.groups() for match in found if match]


class Symbols(unittest.TestCase):
    def test_the_search_sees_what_it_must(self):
        for bad in ["abort", "exit", "_exit", "printf", "__printf_chk", "__fprintf_chk", "vfprintf", "puts", "stderr", "_ZSt4cout",
                    "exit@GLIBC_2.2.5", "write", "fwrite_unlocked", "pthread_exit"]:
            self.assertTrue(FORBIDDEN.match(bad), bad)
        for good in ["snprintf", "__snprintf_chk", "vsnprintf", "memcpy", "_ZN7palpate10ExitSearch5startEi", "__cxa_atexit"]:
            self.assertFalse(FORBIDDEN.match(good), good)

    def test_nothing_in_the_library_prints_or_ends_the_process(self):
        symbols = symbols_of(os.environ["PALPATE_LIBRARY"], "U")
        self.assertGreater(len(symbols), 500, "not the whole library")
        self.assertEqual([pair for pair in symbols if FORBIDDEN.match(pair[1])], [])
        of_clang = {name for name, symbol in symbols_of(os.environ["PALPATE_LIBRARY"], "W") if symbol == CLANG_TERMINATES}
        self.assertEqual({name for name, symbol in symbols if symbol == TERMINATES} - of_clang - {"threads.cpp.o"}, set())


if __name__ == "__main__":
    unittest.main()

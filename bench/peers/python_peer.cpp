#include "peers/python_peer.hpp"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <span>
#include <sstream>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>

#include "temporary_folder.hpp"

namespace palpate::bench {
namespace {

namespace fs = std::filesystem;

template <class Values>
void write_bytes(const fs::path& file, const Values& values) {
  const auto bytes = std::as_bytes(std::span(values));
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!out) throw std::runtime_error(fmt::format("{} cannot be written", file.string()));
}

/// A child that answers a line by a line.
class Child {
 public:
  Child(const PythonPeers& python, const std::vector<std::string>& arguments) {
    std::array<int, 2> to_child{};
    std::array<int, 2> from_child{};
    // Closed in other children: one that kept an end open would keep this one waiting for more.
    if (::pipe2(to_child.data(), O_CLOEXEC) != 0 || ::pipe2(from_child.data(), O_CLOEXEC) != 0)
      throw std::runtime_error("no pipe");
    child_ = ::fork();
    if (child_ < 0) throw std::runtime_error("no process");
    if (child_ == 0) {
      // Ctrl-C reaches the whole group; a child ends with its input.
      static_cast<void>(std::signal(SIGINT, SIG_IGN));
      ::dup2(to_child[0], 0);
      ::dup2(from_child[1], 1);
      std::vector<std::string> words{python.python.string(), python.program.string()};
      words.insert(words.end(), arguments.begin(), arguments.end());
      std::vector<char*> pointers;
      pointers.reserve(words.size() + 1);
      for (std::string& word : words) pointers.push_back(word.data());
      pointers.push_back(nullptr);
      ::execv(words.front().c_str(), pointers.data());
      ::_exit(127);
    }
    ::close(to_child[0]);
    ::close(from_child[1]);
    in_ = ::fdopen(from_child[0], "r");
    out_ = ::fdopen(to_child[1], "w");
  }
  ~Child() {
    static_cast<void>(std::fclose(out_));
    static_cast<void>(std::fclose(in_));
    ::waitpid(child_, nullptr, 0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void tell(const std::string& line) {
    static_cast<void>(std::fprintf(out_, "%s\n", line.c_str()));
    static_cast<void>(std::fflush(out_));
  }
  /// Empty where the child has ended.
  std::string hear() {
    std::string line;
    for (int c = std::fgetc(in_); c != EOF && c != '\n'; c = std::fgetc(in_)) line += static_cast<char>(c);
    return line;
  }

 private:
  pid_t child_ = -1;
  std::FILE* in_ = nullptr;
  std::FILE* out_ = nullptr;
};

class PythonPeer : public Peer {
 public:
  PythonPeer(const PythonPeers& python, const Course& course, const std::string& peer,
             const std::string& mode, int threads)
      : name_(peer), child_(python, {peer, mode, std::to_string(threads), exchange_.path().string()}) {
    const Bodies& bodies = course.scene.bodies;
    write_bytes(exchange_.path() / "tets", bodies.tets());
    write_bytes(exchange_.path() / "triangles", bodies.triangles());
    std::vector<Index> ranges;
    for (const Body& body : bodies.bodies())
      for (const Range& range : {body.points, body.tets, body.triangles})
        ranges.insert(ranges.end(), {range.begin, range.end});
    write_bytes(exchange_.path() / "ranges", ranges);
    child_.tell("start");
    expect("ready");
  }

  Spent find(const Frame& frame, std::vector<Pair>& pairs) override {
    write_bytes(exchange_.path() / "positions", frame.positions);
    write_bytes(exchange_.path() / "edges", frame.edges);
    child_.tell("find");
    std::istringstream answer(expect("found "));
    Spent spent;
    answer >> spent.passed >> spent.processor;
    const fs::path file = exchange_.path() / "pairs";
    pairs.resize(fs::file_size(file) / sizeof(Pair));
    std::ifstream in(file, std::ios::binary);
    in.read(reinterpret_cast<char*>(pairs.data()), static_cast<std::streamsize>(pairs.size() * sizeof(Pair)));
    return spent;
  }

 private:
  /// What follows a word that the next line must begin with.
  std::string expect(const std::string& word) {
    const std::string line = child_.hear();
    if (line.starts_with(word)) return line.substr(word.size());
    throw std::runtime_error(fmt::format("{}: {}", name_, line.empty() ? "its process ended" : line));
  }

  std::string name_;
  TemporaryFolder exchange_;
  Child child_;
};

/// What the program says of a peer: "NAME<tab>ANSWER<tab>MODE<tab>…", or "no REASON".
std::vector<std::string> describe(const PythonPeers& python, Task task, const std::string& peer) {
  Child child(python, {"describe", peer, task == Task::points_in_tets ? "points" : "edges"});
  std::vector<std::string> words(1);
  for (const char c : child.hear()) {
    if (c == '\t') {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  return words;
}

}  // namespace

void add_python(const PythonPeers& python, const Course& course, const std::vector<int>& threads,
                std::vector<Entrant>& entrants, std::vector<Absentee>& absent) {
  static_cast<void>(std::signal(SIGPIPE, SIG_IGN));  // a child that ends is noticed by its missing answer
  for (const std::string peer : {"ipctk", "pbatoolkit"}) {
    std::vector<std::string> words{"its program gives no answer"};
    if (python.python.empty()) {
      words = {"no Python with its package was named (--python)"};
    } else if (const auto said = describe(python, course.task, peer); said.size() > 2) {
      for (const int n : threads) {
        Entrant entrant{said[0], n, said[1] == "candidates" ? Answer::candidates : Answer::own_test, {}};
        for (std::size_t m = 2; m < said.size(); ++m) {
          entrant.modes.push_back({said[m], [&python, &course, peer, mode = said[m], n] {
                                     return std::make_unique<PythonPeer>(python, course, peer, mode, n);
                                   }});
        }
        entrants.push_back(std::move(entrant));
      }
      continue;
    } else if (!said[0].empty()) {
      words = said;
    }
    absent.push_back({peer, words[0]});
  }
}

}  // namespace palpate::bench

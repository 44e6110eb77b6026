// Verdicts of `palpate bench paper` on invented figures: one for each statement of the paper, so that no
// statement is left out.
#include <gtest/gtest.h>

#include "measure/paper.hpp"

namespace palpate::measure {
namespace {

bool says(const Finding& finding, const std::string& text) {
  return finding.why.find(text) != std::string::npos;
}

TEST(EyeFinding, AgreesWhereIndexSortInsertsFasterAndScalesBetter) {
  // Amdahl: 80 % on 2 threads is 1 / (0.2 + 0.4) times as fast, 70 % is 1 / (0.3 + 0.35).
  const Finding good = eye_finding(3.0, 1.0 / 0.6, 1.0 / 0.65, 2);
  EXPECT_EQ(good.verdict, Verdict::agrees);
  EXPECT_TRUE(says(good, "scales better than cuckoo hashing: parallel fractions 80 % and 70 %")) << good.why;
  const Finding worse = eye_finding(3.0, 1.0 / 0.65, 1.0 / 0.6, 2);
  EXPECT_EQ(worse.verdict, Verdict::differs);
  EXPECT_TRUE(says(worse, "scales worse than cuckoo hashing: parallel fractions 70 % and 80 %")) << worse.why;
  EXPECT_EQ(eye_finding(0.9, 1.6, 1.5, 2).verdict, Verdict::differs);
  EXPECT_TRUE(says(eye_finding(3.0, 0.9, 1.5, 2), "fractions none and "));
}

TEST(EyeFinding, OneThreadTellsNothingOfScaling) {
  EXPECT_EQ(eye_finding(3.0, 1.0, 1.0, 1).verdict, Verdict::not_comparable);
  EXPECT_EQ(eye_finding(0.9, 1.0, 1.0, 1).verdict, Verdict::differs);
}

TEST(StructuresFinding, EveryStructureMustTakeLess) {
  const StructureFigures good{.uniform = 200, .compact = 100, .hash = 150, .cuckoo = 160, .occupancy = 0.7};
  const Finding all_less = structures_finding({good}, 0);
  EXPECT_EQ(all_less.verdict, Verdict::agrees);
  EXPECT_TRUE(says(all_less, "compact grids take 0.50, hashing 0.75 and cuckoo hashing 0.80 times"))
      << all_less.why;
  EXPECT_TRUE(says(all_less, "70 % full (paper: 71 %)")) << all_less.why;
  for (double StructureFigures::*structure :
       {&StructureFigures::compact, &StructureFigures::hash, &StructureFigures::cuckoo}) {
    StructureFigures bad = good;
    bad.*structure = 300;
    const Finding finding = structures_finding({good, bad}, 0);
    EXPECT_EQ(finding.verdict, Verdict::differs);
    EXPECT_TRUE(says(finding, " to 1.50")) << finding.why;
  }
  EXPECT_EQ(structures_finding({good}, 1).verdict, Verdict::differs);
}

TEST(ErrorsFinding, FewerCellsMustBeFasterAndErrorsSmall) {
  const ErrorFigures paper{.scene = "eye",
                           .exact = 3.0,
                           .with_27 = 2.8,
                           .with_8 = 1.5,
                           .with_1 = 1.0,
                           .largest = 0.22,
                           .largest_mean = 0.05};
  const Finding good = errors_finding({paper});
  EXPECT_EQ(good.verdict, Verdict::agrees);
  EXPECT_TRUE(
      says(good, "largest deviation 0.22 cm, above the tolerable 1 mm, largest average 0.05 cm, below it"))
      << good.why;
  EXPECT_FALSE(says(good, "does not pay")) << good.why;
  ErrorFigures slower = paper;
  slower.with_8 = 3.0;
  EXPECT_EQ(errors_finding({paper, slower}).verdict, Verdict::differs);
  ErrorFigures needless = paper;
  needless.exact = 0.5;
  EXPECT_TRUE(says(errors_finding({needless}), "does not pay here"));
  EXPECT_TRUE(
      says(errors_finding({needless}), "the exact query is 2.00 times as fast as the fastest of these"));
  ErrorFigures off = paper;
  off.largest_mean = 0.2;
  EXPECT_EQ(errors_finding({off}).verdict, Verdict::differs);
}

TEST(CellSizeFinding, TheMeanEdgeMustBeBestInMostScenes) {
  const CellSizeFigures best{.scene = "a", .best = "1 mean edges", .mean_edge = 1.0, .automatic = 0.9};
  const CellSizeFigures other{.scene = "b", .best = "2 mean edges", .mean_edge = 1.08, .automatic = 1.296};
  EXPECT_EQ(cell_size_finding({best, best, other}).verdict, Verdict::agrees);
  const Finding finding = cell_size_finding({best, other, other});
  EXPECT_EQ(finding.verdict, Verdict::differs);
  EXPECT_TRUE(
      says(finding,
           "a: the best size is 1 mean edges; the mean edge takes 1.00 times as long, auto 0.90 times "
           "(faster than the mean edge by 10 %)"))
      << finding.why;
  EXPECT_TRUE(says(finding, "auto 1.30 times (slower than the mean edge by 20 %)")) << finding.why;
  EXPECT_TRUE(says(finding, "in 1 of 3 scenes")) << finding.why;
}

}  // namespace
}  // namespace palpate::measure

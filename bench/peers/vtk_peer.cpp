#include <vtkCellArray.h>
#include <vtkCellTreeLocator.h>
#include <vtkDoubleArray.h>
#include <vtkGenericCell.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStaticCellLocator.h>
#include <vtkUnstructuredGrid.h>

#include "parallel/parallel.hpp"
#include "peers/timed_peer.hpp"

namespace palpate::bench {
namespace {

/// VTK's locators, one for the tets or triangles of each body, rebuilt in each frame. Points in tets: its
/// FindCell, which returns one tet for a point, by a test of its own. Border edges: FindCellsWithinBounds,
/// and the exact test.
template <class Locator>
class VtkPeer : public TimedPeer {
 public:
  VtkPeer(const Course& course, int threads) : TimedPeer(course, Grouping::per_body), threads_(threads) {
    parts_.resize(problem().groups());
    for (std::size_t g = 0; g < parts_.size(); ++g) make(g);
  }

 protected:
  void search() override {
    for (std::size_t g = 0; g < parts_.size(); ++g) {
      if (problem().task() == Task::edges_on_triangles && problem().first(g).empty()) continue;
      update(parts_[g], problem().bodies().bodies()[g].points);
      for (std::size_t i = 0; i < parts_.size(); ++i)
        if (problem().may_meet(i, g)) ask(i, g);
    }
  }

 private:
  struct Part {
    vtkNew<vtkDoubleArray> coordinates;
    vtkNew<vtkPoints> points;
    vtkSmartPointer<vtkPointSet> mesh;
    vtkNew<Locator> locator;
    Box bounds;
  };

  void make(std::size_t g) {
    const Body& body = problem().bodies().bodies()[g];
    parts_[g] = std::make_unique<Part>();
    Part& part = *parts_[g];
    part.coordinates->SetNumberOfComponents(3);
    part.coordinates->SetNumberOfTuples(body.points.size());
    part.points->SetData(part.coordinates);
    vtkNew<vtkCellArray> cells;
    const auto add = [&](const auto& corners) {
      cells->InsertNextCell(static_cast<int>(corners.size()));
      for (const Index corner : corners) cells->InsertCellPoint(corner - body.points.begin);
    };
    const Range range = problem().second(g);
    if (problem().task() == Task::points_in_tets) {
      for (Index t = range.begin; t < range.end; ++t) add(at(problem().bodies().tets(), t));
      vtkNew<vtkUnstructuredGrid> grid;
      grid->SetPoints(part.points);
      grid->SetCells(VTK_TETRA, cells);
      part.mesh = grid;
    } else {
      for (Index t = range.begin; t < range.end; ++t) add(at(problem().bodies().triangles(), t));
      vtkNew<vtkPolyData> surface;
      surface->SetPoints(part.points);
      surface->SetPolys(cells);
      surface->BuildCells();  // before several threads ask for cells
      part.mesh = surface;
    }
    part.locator->SetDataSet(part.mesh);
  }

  void update(std::unique_ptr<Part>& part, Range points) const {
    part->bounds = {};
    double* out = part->coordinates->GetPointer(0);
    for (Index p = points.begin; p < points.end; ++p) {
      const Vec3& x = at(problem().positions(), p);
      *out++ = x.x;
      *out++ = x.y;
      *out++ = x.z;
      part->bounds.extend(x);
    }
    part->coordinates->Modified();
    part->points->Modified();
    part->mesh->Modified();
    part->locator->Modified();
    part->locator->BuildLocator();
  }

  void ask(std::size_t i, std::size_t g) {
    const std::span<const Index> list = problem().first(i);
    parallel::for_chunks(threads_, list.size(), 512, [&](std::size_t begin, std::size_t end, std::size_t) {
      vtkNew<vtkGenericCell> cell;
      vtkNew<vtkIdList> near;
      for (std::size_t k = begin; k < end; ++k) {
        const Box box = problem().first_box(list[k]);
        if (!parts_[g]->bounds.overlaps(box)) continue;
        if (problem().task() == Task::points_in_tets) {
          ask_point(list[k], box.lower, g, cell);
        } else {
          ask_edge(list[k], box, g, near);
        }
      }
    });
  }
  void ask_point(Index point, const Vec3& x, std::size_t g, vtkGenericCell* cell) {
    double place[3]{x.x, x.y, x.z};
    double parametric[3];
    double weights[8];
    const vtkIdType found = parts_[g]->locator->FindCell(place, 0.0, cell, parametric, weights);
    if (found >= 0) answer({point, problem().second(g).begin + static_cast<Index>(found)});
  }
  void ask_edge(Index edge, const Box& box, std::size_t g, vtkIdList* near) {
    double bounds[6]{box.lower.x, box.upper.x, box.lower.y, box.upper.y, box.lower.z, box.upper.z};
    near->Reset();
    parts_[g]->locator->FindCellsWithinBounds(bounds, near);
    for (vtkIdType n = 0; n < near->GetNumberOfIds(); ++n)
      propose(edge, problem().second(g).begin + static_cast<Index>(near->GetId(n)));
  }

  parallel::Threads threads_;
  std::vector<std::unique_ptr<Part>> parts_;
};

template <class Locator>
Mode mode_of(const char* name, const Course& course, int threads) {
  return {name, [&course, threads] { return std::make_unique<VtkPeer<Locator>>(course, threads); }};
}

}  // namespace

void add_vtk(const Course& course, const std::vector<int>& threads, std::vector<Entrant>& entrants) {
  const bool points = course.task == Task::points_in_tets;
  for (const int n : threads) {
    Entrant entrant{"VTK locator", n, points ? Answer::own_test : Answer::exact, {}};
    entrant.modes.push_back(mode_of<vtkStaticCellLocator>("static cell locator", course, n));
    // Its FindCellsWithinBounds is not there in VTK 9.1.
    if (points) entrant.modes.push_back(mode_of<vtkCellTreeLocator>("cell tree locator", course, n));
    entrants.push_back(std::move(entrant));
  }
}

}  // namespace palpate::bench

// The module libscanknit_step_reader.so.
#include <fmt/format.h>

#include <BRepBndLib.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <IFSelect_ReturnStatus.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <Poly_Triangulation.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "core/system/module.h"
#include "core/version.h"
#include "export/mesh/mesh_builder.h"
#include "export/step/step_reader.h"

namespace scanknit {
namespace {

constexpr double kMostTurn_rad = 0.2;  // between neighbouring triangles of a curved face

Result<TopoDS_Shape> shape_of(std::string_view bytes) {
  STEPControl_Controller::Init();
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  STEPControl_Reader reader;
  std::istringstream text{std::string(bytes)};
  if (reader.ReadStream("model", text) != IFSelect_RetDone) {
    return input_error("not a STEP file, or damaged: its entities cannot be read");
  }
  reader.TransferRoots();
  const TopoDS_Shape shape = reader.OneShape();
  if (shape.IsNull()) return input_error("no shape in the STEP file: expected solids, shells or faces");
  return shape;
}

/// Error (kInput): no extent.
Result<void> triangulate(const TopoDS_Shape& shape) {
  Bnd_Box box;
  BRepBndLib::Add(shape, box, /*useTriangulation=*/false);
  const double diagonal = box.IsVoid() || box.IsOpen() ? 0 : std::sqrt(box.SquareExtent());
  if (!(diagonal > 0) || !std::isfinite(diagonal)) return input_error("the STEP model has no finite extent");
  constexpr double kKept = 0.5;  // the mesher may exceed what it is asked for by some tenths
  const BRepMesh_IncrementalMesh mesher(shape, kKept * kStepDeviation * diagonal, /*isRelative=*/false, kMostTurn_rad,
                                        /*isInParallel=*/false);
  return {};
}

/// Appends the corners of a face's triangles; false: it has none.
bool append(const TopoDS_Face& face, std::vector<Eigen::Vector3f>& corners) {
  TopLoc_Location place;
  const Handle(Poly_Triangulation) triangles = BRep_Tool::Triangulation(face, place);
  if (triangles.IsNull() || triangles->NbTriangles() == 0) return false;
  const gp_Trsf& T_model_face = place.Transformation();
  const bool is_turned = (face.Orientation() == TopAbs_REVERSED) != T_model_face.IsNegative();
  for (int i = 1; i <= triangles->NbTriangles(); ++i) {
    int nodes[3];
    triangles->Triangle(i).Get(nodes[0], nodes[is_turned ? 2 : 1], nodes[is_turned ? 1 : 2]);
    for (const int node : nodes) {
      const gp_Pnt p = triangles->Node(node).Transformed(T_model_face);
      corners.emplace_back(static_cast<float>(p.X()), static_cast<float>(p.Y()), static_cast<float>(p.Z()));
    }
  }
  return true;
}

/// Faces that the text has and the shape has not. A shape may have more: closed faces are cut, parts are placed twice.
std::size_t faces_missing(std::string_view text, std::size_t faces) {
  std::size_t stated = 0;
  for (const std::string_view kind : {"ADVANCED_FACE", "FACE_SURFACE"}) {
    for (std::size_t at = text.find(kind); at != std::string_view::npos; at = text.find(kind, at + kind.size()))
      ++stated;
  }
  return stated > faces ? stated - faces : 0;
}

Result<Mesh> mesh_of(std::string_view bytes, const Limits& limits, MeshNotes* notes) {
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));  // they write to standard output
  try {
    const auto shape = shape_of(bytes);
    if (!shape) return shape.error();
    if (auto done = triangulate(*shape); !done) return done.error();
    std::vector<Eigen::Vector3f> corners;
    std::size_t faces = 0, without = 0;
    for (TopExp_Explorer explorer(*shape, TopAbs_FACE); explorer.More(); explorer.Next()) {
      ++faces;
      if (!append(TopoDS::Face(explorer.Current()), corners)) ++without;
      if (corners.size() / 3 > limits.max_mesh_triangles) {
        return input_error(fmt::format("more triangles than the limit of {}", limits.max_mesh_triangles));
      }
    }
    if (corners.empty()) return input_error("no face in the STEP file: expected solids, shells or faces");
    without += faces_missing(bytes, faces);
    if (without > 0 && notes != nullptr) {
      notes->warnings.push_back(fmt::format("faces of the STEP model that cannot be meshed are left out: {}", without));
    }
    Mesh mesh = weld(corners);
    std::erase_if(mesh.triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
    return mesh;
  } catch (const Standard_Failure& problem) {
    return input_error(std::string("the STEP file cannot be understood: ") + problem.GetMessageString());
  }
}

}  // namespace
}  // namespace scanknit

extern "C" __attribute__((visibility("default"))) const scanknit::ModuleEntry* scanknit_module() {
  using namespace scanknit;
  static constexpr StepReader kOffers{mesh_of};
  static constexpr ModuleEntry kEntry{kVersion, &kOffers};
  return &kEntry;
}

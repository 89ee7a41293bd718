// STEP models for tests, as Open CASCADE writes them.
#pragma once

#include <gtest/gtest.h>

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Writer.hxx>
#include <filesystem>

namespace scanknit::test {

/// `unit`: of the file's numbers, "MM", "M" or "INCH"; the shape is in millimetres.
inline void write_step(const TopoDS_Shape& shape, const char* unit, const std::filesystem::path& file) {
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
  STEPControl_Controller::Init();
  Interface_Static::SetCVal("write.step.unit", unit);
  STEPControl_Writer writer;  // takes the unit as it is now
  ASSERT_EQ(writer.Transfer(shape, STEPControl_AsIs), IFSelect_RetDone);
  ASSERT_EQ(writer.Write(file.c_str()), IFSelect_RetDone);
}

/// A block of 60 x 40 x 20 mm with a bore of 10 mm radius through it.
inline TopoDS_Shape bored_block() {
  const TopoDS_Shape block = BRepPrimAPI_MakeBox(60, 40, 20).Shape();
  const TopoDS_Shape bore = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(30, 20, -5), gp_Dir(0, 0, 1)), 10, 30).Shape();
  return BRepAlgoAPI_Cut(block, bore).Shape();
}

}  // namespace scanknit::test

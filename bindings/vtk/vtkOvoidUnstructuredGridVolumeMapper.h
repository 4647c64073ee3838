// SPDX-License-Identifier: Apache-2.0
/**
 * @class   vtkOvoidUnstructuredGridVolumeMapper
 * @brief   draws meshes and particles with Ovoid
 *
 * A volume mapper for any vtkUnstructuredGrid, whatever its cells, with data at points or cells,
 * and for other point sets: structured grids, and points without cells, which are drawn as a field
 * of particles. Unlike VTK's mappers of unstructured grids it shades, takes gradient opacity, and
 * needs no tetrahedra. The vtkVolumeProperty, the camera, the lights and clipping planes mean what
 * they mean to VTK's mappers; what is not drawn is told by vtkErrorMacro in one line, and nothing
 * is drawn. docs/vtk.md lists both.
 *
 * Points and values are shared with their arrays while kernels are made of them, once; the kernels
 * are the field's own. They are made anew where points, cells, values or the volume's matrix have
 * changed. Opaque props of the same renderer hide the volume and are hidden by it. The picture is
 * made on the processor (or a Vulkan device) and drawn over the viewport; it writes no depth.
 */
#pragma once

#include <functional>
#include <memory>

#include "vtkOvoidModule.h"
#include "vtkUnstructuredGridVolumeMapper.h"

class vtkImageData;
class vtkUnstructuredGridBase;

namespace ovoid {
namespace mappers {  // two steps: VTK's wrapper reads no other way
class VolumePainter;
struct MapperSettings;
}  // namespace mappers
}  // namespace ovoid

class VTKOVOID_EXPORT vtkOvoidUnstructuredGridVolumeMapper
    : public vtkUnstructuredGridVolumeMapper {
 public:
  static vtkOvoidUnstructuredGridVolumeMapper* New();
  // clang-format off
  vtkTypeMacro(vtkOvoidUnstructuredGridVolumeMapper, vtkUnstructuredGridVolumeMapper)
      // clang-format on
      void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Takes any vtkPointSet: unstructured and structured grids, and points.
   */
  void SetInputData(vtkUnstructuredGridBase* grid) override;
  void SetInputData(vtkDataSet* points) override;
  ///@}

  ///@{
  /**
   * Which number of an array of several is drawn. DISABLED: as the property says, which is the one
   * independent component whose weight is not 0. MAGNITUDE: the Euclidean norm. COMPONENT:
   * VectorComponent. The names are vtkSmartVolumeMapper's.
   */
  enum VectorModeType { DISABLED = -1, MAGNITUDE = 0, COMPONENT = 1 };
  vtkSetClampMacro(VectorMode, int, DISABLED, COMPONENT);
  vtkGetMacro(VectorMode, int);
  vtkSetClampMacro(VectorComponent, int, 0, VTK_INT_MAX);
  vtkGetMacro(VectorComponent, int);
  ///@}

  ///@{
  /**
   * Where pictures are made: on a hardware Vulkan device where there is one, else the processor
   * (AUTO, the default); or on one of the two.
   */
  enum BackendType { AUTO = 0, CPU = 1, VULKAN = 2 };
  vtkSetClampMacro(Backend, int, AUTO, VULKAN);
  vtkGetMacro(Backend, int);
  ///@}

  ///@{
  /**
   * Threads of the processor; 0, the default: one per hardware thread.
   */
  vtkSetClampMacro(NumberOfThreads, int, 0, VTK_INT_MAX);
  vtkGetMacro(NumberOfThreads, int);
  ///@}

  ///@{
  /**
   * The distance of sheets of samples, in world units; 0, the default: as the data need it.
   */
  vtkSetClampMacro(SampleDistance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(SampleDistance, double);
  ///@}

  ///@{
  /**
   * With AutoAdjustSampleDistances, which is on by default, a picture has fewer pixels where the
   * time that the render window grants (DesiredUpdateRate) is too short for all of them: one for
   * ImageSampleDistance x ImageSampleDistance of the viewport's, at most
   * MaximumImageSampleDistance. Off: all pixels.
   */
  vtkSetClampMacro(AutoAdjustSampleDistances, vtkTypeBool, 0, 1);
  vtkGetMacro(AutoAdjustSampleDistances, vtkTypeBool);
  vtkBooleanMacro(AutoAdjustSampleDistances, vtkTypeBool);
  vtkSetClampMacro(MaximumImageSampleDistance, double, 1.0, 100.0);
  vtkGetMacro(MaximumImageSampleDistance, double);
  double GetImageSampleDistance();
  ///@}

  ///@{
  /**
   * The box of the world (x, x, y, y, z, z; infinite sides are none) within which this mapper
   * draws, while others draw what lies beyond: of the same data, or of other pieces. Unlike
   * clipping, it leaves no face: values and light at its sides are those of the data on both, which
   * the input must therefore hold a few cells beyond. With one SampleDistance, boxes drawn from the
   * farthest to the nearest join to the picture of the whole. The default is everywhere.
   */
  vtkSetVector6Macro(OwnedBounds, double);
  vtkGetVector6Macro(OwnedBounds, double);
  void SetOwnedBoundsToAll();
  ///@}

  ///@{
  /**
   * The input's; with owned bounds wider, since kernels reach beyond their data, and compositors
   * cut pictures where bounds end.
   */
  double* GetBounds() override;
  using Superclass::GetBounds;
  ///@}

  ///@{
  /**
   * Makes the field of the input, as a frame would, for a volume with this mapper; nothing is
   * drawn. GetFieldSums() are then sums over the kernels whose centres lie within the owned bounds;
   * those of boxes that fill space add up to those of the whole, of which SampleDistanceOf() makes
   * a distance of sheets that suits all boxes. False, and an error, if there is no field to be
   * made.
   */
  bool UpdateField(vtkVolume* vol);
  vtkGetVectorMacro(FieldSums, double, 5);
  static double SampleDistanceOf(const double sums[5]);
  ///@}

  ///@{
  /**
   * Seconds of the last frame: of Render() as a whole, of Ovoid's renderer in it, and of the
   * exchange with OpenGL (reading depth, drawing the picture). 0 before the first.
   */
  double GetRenderTime();
  double GetFrameTime();
  double GetDisplayTime();
  ///@}

  /**
   * When the kernels were made of the data last; 0 if never. Frames, cameras and properties leave
   * them as they are.
   */
  vtkMTimeType GetFieldTime();

  /**
   * The bytes that the kernels take.
   */
  vtkTypeInt64 GetFieldMemory();

  ///@{
  /**
   * The last frame as an image, its first row at the bottom: four floats per pixel, premultiplied
   * and without what is behind; or the depth along the view axis, in world units, where opacity
   * first reaches 1/2, infinite where it does not.
   */
  void GetColorImage(vtkImageData* image);
  void GetDepthImage(vtkImageData* image);
  ///@}

  /**
   * WARNING: INTERNAL METHOD - NOT INTENDED FOR GENERAL USE
   */
  void Render(vtkRenderer* ren, vtkVolume* vol) override;
  void ReleaseGraphicsResources(vtkWindow* window) override;

 protected:
  vtkOvoidUnstructuredGridVolumeMapper();
  ~vtkOvoidUnstructuredGridVolumeMapper() override;
  int FillInputPortInformation(int port, vtkInformation* information) override;

  int VectorMode = DISABLED;
  int VectorComponent = 0;
  int Backend = AUTO;
  int NumberOfThreads = 0;
  double SampleDistance = 0;
  vtkTypeBool AutoAdjustSampleDistances = 1;
  double MaximumImageSampleDistance = 10;
  double OwnedBounds[6];
  double FieldSums[5] = {0, 0, 0, 0, 0};

 private:
  void WithSettings(const std::function<void(const ovoid::mappers::MapperSettings&)>& use);

  vtkOvoidUnstructuredGridVolumeMapper(const vtkOvoidUnstructuredGridVolumeMapper&) = delete;
  void operator=(const vtkOvoidUnstructuredGridVolumeMapper&) = delete;

  std::unique_ptr<ovoid::mappers::VolumePainter> Painter;
};

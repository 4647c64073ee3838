// SPDX-License-Identifier: Apache-2.0
/**
 * @class   vtkOvoidVolumeMapper
 * @brief   draws vtkImageData and vtkRectilinearGrid with Ovoid
 *
 * A volume mapper as VTK's own are: give it to a vtkVolume. The vtkVolumeProperty, the camera, the
 * lights, cropping and clipping planes mean what they mean to VTK's mappers; what is not drawn is
 * told by vtkErrorMacro in one line, and nothing is drawn. docs/vtk.md lists both.
 *
 * The samples are shared with the vtkDataArray, not copied, where its type and layout allow
 * (unsigned and signed char and short, and float, in VTK's standard layout). A changed array is
 * noticed by its MTime; nothing else makes the field anew. Opaque props of the same renderer hide
 * the volume and are hidden by it. The picture is made on the processor (or a Vulkan device) and
 * drawn over the viewport; it writes no depth.
 */
#pragma once

#include <functional>
#include <memory>

#include "vtkOvoidModule.h"
#include "vtkVolumeMapper.h"

class vtkImageData;

namespace ovoid {
namespace mappers {  // two steps: VTK's wrapper reads no other way
class VolumePainter;
struct MapperSettings;
}  // namespace mappers
}  // namespace ovoid

class VTKOVOID_EXPORT vtkOvoidVolumeMapper : public vtkVolumeMapper {
 public:
  static vtkOvoidVolumeMapper* New();
  // clang-format off
  vtkTypeMacro(vtkOvoidVolumeMapper, vtkVolumeMapper)
      // clang-format on
      void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Which numbers of an array of several are drawn. DISABLED: as the property says, which are the
   * independent components whose weights are not 0, at most four, each with its own functions,
   * shading and weight; or two or four dependent ones. MAGNITUDE: the Euclidean norm. COMPONENT:
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
   * What stands at every sample. AUTO, the default: as the program chooses, the cubic B-spline
   * through the samples' values, but for labels. GAUSSIAN and SMOOTHING_BSPLINE never overshoot
   * where values jump, and blur a little. The property's interpolation type is not read.
   * docs/kernels.md.
   */
  enum KernelType {
    AUTO_KERNEL = 0,
    BSPLINE = 1,
    CATMULL_ROM = 2,
    GAUSSIAN = 3,
    SMOOTHING_BSPLINE = 4
  };
  vtkSetClampMacro(Kernel, int, AUTO_KERNEL, SMOOTHING_BSPLINE);
  vtkGetMacro(Kernel, int);
  void SetKernelToAuto() { this->SetKernel(AUTO_KERNEL); }
  void SetKernelToBSpline() { this->SetKernel(BSPLINE); }
  void SetKernelToCatmullRom() { this->SetKernel(CATMULL_ROM); }
  void SetKernelToGaussian() { this->SetKernel(GAUSSIAN); }
  void SetKernelToSmoothingBSpline() { this->SetKernel(SMOOTHING_BSPLINE); }
  ///@}

  ///@{
  /**
   * Of programs that were written for vtkSmartVolumeMapper, which chooses among VTK's renderers:
   * they change nothing here.
   */
  void SetRequestedRenderMode(int) {}
  void SetRequestedRenderModeToDefault() {}
  void SetRequestedRenderModeToRayCast() {}
  void SetRequestedRenderModeToGPU() {}
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
   * Sheets parallel to the picture, always: pictures of parts of a volume then join to the picture
   * of the whole. Off, the default: sheets parallel to a grid's planes where that is faster.
   */
  vtkSetClampMacro(ImageSheets, vtkTypeBool, 0, 1);
  vtkGetMacro(ImageSheets, vtkTypeBool);
  vtkBooleanMacro(ImageSheets, vtkTypeBool);
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
   * drawn. GetFieldSampleDistance() is then the distance of sheets that frames take where
   * SampleDistance is 0. False, and an error, if there is none to be made.
   */
  bool UpdateField(vtkVolume* vol);
  vtkGetMacro(FieldSampleDistance, double);
  ///@}

  /**
   * Which kernel stands at the samples of the field that was made last; never AUTO_KERNEL.
   */
  int GetFieldKernel();

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
   * When the field was made of the data last; 0 if never. Frames, cameras, properties and matrices
   * leave it as it is.
   */
  vtkMTimeType GetFieldTime();

  /**
   * Whether the field's samples are the array's own memory. Not of arrays of other types and
   * layouts than the above, of several components, and where points are blanked.
   */
  bool GetSharesMemory();

  /**
   * The bytes that the field holds, beside samples that it shares: coefficients of the kernels,
   * ranges of values.
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
  vtkOvoidVolumeMapper();
  ~vtkOvoidVolumeMapper() override;

  int VectorMode = DISABLED;
  int VectorComponent = 0;
  int Kernel = AUTO_KERNEL;
  int Backend = AUTO;
  int NumberOfThreads = 0;
  double SampleDistance = 0;
  vtkTypeBool AutoAdjustSampleDistances = 1;
  double MaximumImageSampleDistance = 10;
  vtkTypeBool ImageSheets = 0;
  double OwnedBounds[6];
  double FieldSampleDistance = 0;

 private:
  void WithSettings(const std::function<void(const ovoid::mappers::MapperSettings&)>& use);

  vtkOvoidVolumeMapper(const vtkOvoidVolumeMapper&) = delete;
  void operator=(const vtkOvoidVolumeMapper&) = delete;

  std::unique_ptr<ovoid::mappers::VolumePainter> Painter;
};

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <fmt/format.h>
#include <fstream>
#include <iostream>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkImage.h>
#include <itkImageFileReader.h>
#include <itkImageSeriesReader.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkVersion.h>
#include <numbers>
#include <optional>
#include <sstream>
#include <string_view>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "io/file_bytes.hpp"
#include "label_map.hpp"
#include "meta_voxels.hpp"
#include "nifti_header.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;
using Image = itk::Image<double, 3>;

constexpr std::int64_t most_voxels = 300'000'000;
constexpr double largest_label = 1e9;

std::string lower_name(const fs::path& path) {
  std::string name = path.filename().string();
  std::ranges::transform(name, name.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name;
}

/// Discards what the libraries below ITK print: failures are reported by an Error only.
class Silence {
 public:
  Silence() : out_(std::cout.rdbuf(nullptr)), error_(std::cerr.rdbuf(nullptr)) {}
  ~Silence() {
    std::cout.rdbuf(out_);  // also clears the error state of the discarded output
    std::cerr.rdbuf(error_);
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  std::streambuf* out_;
  std::streambuf* error_;
};

/// The reader for an extension; null where there is none.
itk::ImageIOBase::Pointer reader_of(const fs::path& path) {
  const std::string name = lower_name(path);
  const auto ends = [&](std::string_view end) { return name.ends_with(end); };
  if (ends(".nrrd") || ends(".nhdr")) return itk::NrrdImageIO::New().GetPointer();
  if (ends(".nii") || ends(".nii.gz")) return itk::NiftiImageIO::New().GetPointer();
  if (ends(".mha") || ends(".mhd")) return itk::MetaImageIO::New().GetPointer();
  return nullptr;
}

/// The first line of ITK's message, without the place in its sources.
/// The last cause in a message of the NRRD library, and the field of the header that it names. The library
/// lists its functions from the outermost to the one that failed, a line each: "[nrrd] name: words".
std::string nrrd_message(const std::string& text) {
  constexpr std::string_view mark = "[nrrd] ";
  constexpr std::string_view parsing = "trouble parsing ";
  std::string cause = text.substr(text.rfind(mark) + mark.size());
  if (const auto name = cause.find(": "); name != std::string::npos) cause.erase(0, name + 2);
  cause.erase(cause.find_last_not_of(" .!") + 1);
  const auto begin = text.find(parsing);
  const auto end = text.find(" info |", begin);
  if (begin == std::string::npos || end == std::string::npos) return fmt::format("damaged data ({})", cause);
  const auto from = begin + parsing.size();
  return fmt::format("'{}' that cannot be read ({})", text.substr(from, end - from), cause);
}

std::string short_message(const itk::ExceptionObject& error) {
  std::string text = error.GetDescription();
  std::ranges::replace(text, '\n', ' ');
  if (text.find("[nrrd] ") != std::string::npos) return nrrd_message(text);
  // Of MetaIO. The "Reason" that it adds is the last failure of any call to the system.
  if (text.find("File cannot be read: ") != std::string::npos) return "a header that cannot be read";
  // An address as in "itk::ERROR: NrrdImageIO(0x558cf5b8a2d0): " is of no use in a message.
  if (const auto place = text.find("): "); text.find("(0x") < place && place != std::string::npos)
    text.erase(0, place + 3);
  return text;
}

void check_header(const itk::ImageIOBase& io, const std::string& source) {
  if (io.GetNumberOfComponents() != 1) {
    throw Error(source, "header", fmt::format("{} values a voxel", io.GetNumberOfComponents()),
                "one value a voxel: a label map without overlapping segments (3D Slicer: export the "
                "segmentation to a label map)");
  }
  std::int64_t voxels = 1;
  for (unsigned axis = 0; axis < io.GetNumberOfDimensions(); ++axis) {
    const auto count = static_cast<std::int64_t>(io.GetDimensions(axis));
    if (axis >= 3 && count != 1) {
      throw Error(source, "header", fmt::format("{} dimensions", io.GetNumberOfDimensions()), "three");
    }
    if (count > most_voxels || (voxels *= count) > most_voxels) {
      throw Error(source, "header", "more than " + std::to_string(most_voxels) + " voxels",
                  "fewer voxels: crop the map to the organs");
    }
  }
  if (io.GetNumberOfDimensions() < 3) {
    throw Error(source, "header", fmt::format("{} dimensions", io.GetNumberOfDimensions()), "three");
  }
}

/// The file of the voxels where the header names another one: always in .nhdr and .mhd, sometimes in .nrrd
/// and .mha. Lists and patterns of files ("LIST", "slice%03d.raw 1 20 1") are given as they are written.
std::optional<std::string> file_of_voxels(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  for (std::string line; std::getline(file, line) && !line.empty() && line != "\r";) {
    const bool is_nrrd = line.starts_with("data file:") || line.starts_with("datafile:");
    if (!is_nrrd && !line.starts_with("ElementDataFile")) continue;
    std::string name = line.substr(std::min(line.find_first_of(":="), line.size() - 1) + 1);
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!name.empty() && blank(name.back())) name.pop_back();
    name.erase(name.begin(), std::ranges::find_if_not(name, blank));
    if (name == "LOCAL") return std::nullopt;
    return name;
  }
  return std::nullopt;
}

/// Refuses pipes and devices, since reading them may never end.
void check_file_of_voxels(const fs::path& path) {
  const std::optional<std::string> name = file_of_voxels(path);
  if (!name) return;
  const fs::path file = path.parent_path() / *name;
  std::error_code ignored;
  const fs::file_status status = fs::status(file, ignored);
  if (fs::exists(status) && !fs::is_regular_file(status))
    io::require_regular_file(file, "the voxels of " + path.string());
}

/// Refuses a file that is too small for its voxels, before memory is allocated for them.
void check_bytes(const itk::ImageIOBase& io, const fs::path& path) {
  const std::string name = lower_name(path);
  if (name.ends_with(".nhdr") || name.ends_with(".mhd") || file_of_voxels(path)) return;
  constexpr double most_deflated = 1032.0;  // zlib never makes more bytes from one
  const auto bytes = static_cast<double>(fs::file_size(path));
  double needed = io.GetComponentSize();
  for (unsigned axis = 0; axis < io.GetNumberOfDimensions(); ++axis) {
    needed *= static_cast<double>(io.GetDimensions(axis));
  }
  if (needed > most_deflated * bytes) {
    throw Error(path.string(), "header",
                fmt::format("voxels of {:.0f} bytes in a file of {:.0f}", needed, bytes),
                "a file that holds its voxels");
  }
}

std::int64_t voxels_of(const itk::ImageIOBase& io) {
  std::int64_t voxels = 1;
  for (unsigned axis = 0; axis < io.GetNumberOfDimensions(); ++axis)
    voxels *= static_cast<std::int64_t>(io.GetDimensions(axis));
  return voxels;
}

void require_meta_image(itk::MetaImageIO& io, const fs::path& path) {
  const MetaImage& image = *io.GetMetaImagePointer();
  MetaVoxels voxels;
  for (unsigned axis = 0; axis < io.GetNumberOfDimensions(); ++axis)
    voxels.size.push_back(static_cast<std::int64_t>(io.GetDimensions(axis)));
  voxels.voxel_bytes = io.GetComponentSize();
  voxels.file = image.ElementDataFileName();
  voxels.binary = image.BinaryData();
  voxels.compressed = image.CompressedData();
  voxels.skipped_bytes = image.HeaderSize();
  require_meta_voxels(path, voxels);
}

Image::Pointer read_file(const fs::path& path, const itk::ImageIOBase::Pointer& io) {
  if (fs::file_size(path) == 0) throw Error(path.string(), "", "an empty file", "a label map");
  std::optional<NiftiHeader> nifti;
  if (dynamic_cast<const itk::NiftiImageIO*>(io.GetPointer()) != nullptr) nifti.emplace(path);
  if (!nifti) check_file_of_voxels(path);
  io->SetFileName(path.string());
  io->ReadImageInformation();
  check_header(*io, path.string());
  check_bytes(*io, path);
  if (nifti) nifti->require_voxels(voxels_of(*io));
  if (auto* meta = dynamic_cast<itk::MetaImageIO*>(io.GetPointer())) require_meta_image(*meta, path);
  const auto reader = itk::ImageFileReader<Image>::New();
  reader->SetImageIO(io);
  reader->SetFileName(path.string());
  reader->Update();
  return reader->GetOutput();
}

std::string text_of(const itk::MetaDataDictionary& header, const std::string& key) {
  std::string text;
  itk::ExposeMetaData(header, key, text);
  return text;
}

/// GDCM leaves the position out of slices that are no CT or MR ("secondary capture"), and says nothing.
void check_position(const Image& image, const itk::MetaDataDictionary& first, const std::string& source) {
  std::string text = text_of(first, "0020|0032");
  std::ranges::replace(text, '\\', ' ');
  std::istringstream position(text);
  constexpr double near = 1e-3;
  for (unsigned a = 0; a < 3; ++a) {
    double value = 0.0;
    if (position >> value && std::abs(value - image.GetOrigin()[a]) > near) {
      throw Error(source, "", "a DICOM object type whose slice positions cannot be read",
                  "CT or MR slices, or the map as NRRD or NIfTI");
    }
  }
}

Image::Pointer read_series(const fs::path& folder) {
  const auto names = itk::GDCMSeriesFileNames::New();
  names->SetGlobalWarningDisplay(false);
  names->SetUseSeriesDetails(true);
  names->SetDirectory(folder.string());
  const auto series = names->GetSeriesUIDs();
  if (series.size() != 1) {
    throw Error(folder.string(), "", fmt::format("{} DICOM series", series.size()),
                series.empty() ? "a folder with one" : "one series: put each into a folder of its own");
  }
  const auto reader = itk::ImageSeriesReader<Image>::New();
  reader->SetImageIO(itk::GDCMImageIO::New());
  reader->SetFileNames(names->GetFileNames(series.front()));
  reader->Update();
  check_position(*reader->GetOutput(), *reader->GetMetaDataDictionaryArray()->front(), folder.string());
  return reader->GetOutput();
}

/// The segments that 3D Slicer names in the header of a .seg.nrrd.
std::vector<LabelName> segments_of(const itk::MetaDataDictionary& header) {
  std::vector<LabelName> names;
  for (int segment = 0;; ++segment) {
    const auto value = [&](const char* key) {
      return text_of(header, fmt::format("Segment{}_{}", segment, key));
    };
    std::istringstream label(value("LabelValue"));
    LabelName name;
    if (!(label >> name.label)) return names;
    name.name = value("Name");
    std::istringstream color(value("Color"));
    if (std::array<double, 3> rgb{}; color >> rgb[0] >> rgb[1] >> rgb[2]) name.color = rgb;
    names.push_back(name);
  }
}

std::int32_t label_of(double value, const std::string& source, std::size_t voxel) {
  if (value >= 0.0 && value <= largest_label && value == std::floor(value))
    return static_cast<std::int32_t>(value);
  throw Error(source, fmt::format("voxel {}", voxel), fmt::format("the value {}", value),
              "a whole number >= 0: a label map, not the image that was segmented");
}

/// Refuses axes that are not at right angles: sizes, distances and volumes assume that voxels are boxes.
void check_axes(const Frame& frame, const std::string& source) {
  constexpr double near = 1e-3;
  for (std::size_t a = 0; a < 3; ++a) {
    const double long_axis = length(frame.axes[a]);
    if (std::abs(long_axis - 1.0) > near) {
      throw Error(source, "header", fmt::format("a direction of length {:.4g}", long_axis),
                  "directions of length 1: how large voxels are is in the spacing alone");
    }
    const double across = dot(frame.axes[a], frame.axes[(a + 1) % 3]);
    if (std::abs(across) > near) {
      throw Error(source, "header",
                  fmt::format("axes at {:.4g} degrees", std::acos(across) * 180.0 / std::numbers::pi),
                  "axes at right angles: resample the map");
    }
  }
}

void check_voxel(double size, const std::string& source) {
  constexpr double least = 1e-9;
  constexpr double most = 1e6;  // with larger ones CGAL's mesher loses digits and does not end
  if (size >= least && size <= most) return;
  throw Error(source, "header", fmt::format("a voxel of {:.4g} mm", size), "voxels from 1e-9 to 1e6 mm");
}

LabelMap label_map_of(const Image& image, const std::string& source) {
  LabelMap map;
  const auto size = image.GetLargestPossibleRegion().GetSize();
  const std::array<double Vec3::*, 3> components{&Vec3::x, &Vec3::y, &Vec3::z};
  for (unsigned a = 0; a < 3; ++a) {
    map.size[a] = static_cast<int>(size[a]);
    map.spacing.*components[a] = image.GetSpacing()[a];
    check_voxel(image.GetSpacing()[a], source);
    map.frame.origin.*components[a] = image.GetOrigin()[a];
    for (unsigned b = 0; b < 3; ++b) map.frame.axes[b].*components[a] = image.GetDirection()[a][b];
  }
  check_axes(map.frame, source);
  const std::size_t voxels = image.GetLargestPossibleRegion().GetNumberOfPixels();
  map.labels.reserve(voxels);
  for (std::size_t v = 0; v < voxels; ++v)
    map.labels.push_back(label_of(image.GetBufferPointer()[v], source, v));
  map.names = segments_of(image.GetMetaDataDictionary());
  return map;
}

}  // namespace

bool is_label_map(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored) || reader_of(path) != nullptr;
}

LabelMap read_label_map(const fs::path& path) {
  const std::string source = path.string();
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) io::require_regular_file(path, "a label map, or a folder of slices");
  itk::Object::SetGlobalWarningDisplay(false);
  const Silence silence;
  try {
    const auto io = reader_of(path);
    return label_map_of(*(io ? read_file(path, io) : read_series(path)), source);
  } catch (const itk::ExceptionObject& error) {
    const std::string message = short_message(error);
    if (message.find("orthonormal") != std::string::npos) {
      throw Error(
          source, "header", "directions that are no unit vectors at right angles",
          "an orientation that agrees with the size of voxels (NIfTI: sform and pixdim): resample the map");
    }
    throw Error(source, "", message, "a label map that can be read");
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {  // damaged headers make ITK's own code throw these
    throw Error(source, "", error.what(), "a label map that can be read");
  }
}

}  // namespace palpate::app

#include <palpate/tissues.hpp>

namespace palpate {
namespace {

/// Poisson's ratio of nearly incompressible tissue.
constexpr double wet = 0.45;

/// Young's modulus from a shear modulus.
constexpr double young_of(double shear, double poisson_ratio) {
  return 2.0 * (1.0 + poisson_ratio) * shear;
}

// Densities are those of ICRU Report 44 (1989) and 46 (1992); tendon and sclera have the density of
// cartilage.
constexpr std::array<TissueInfo, tissue_names.size()> infos{{
    {young_of(2000.0, wet), wet, 1060.0,
     "shear stiffness 2.0 +- 0.3 kPa, 12 volunteers, in vivo, MR elastography",
     "Rouviere et al., Radiology 240 (2006) 440-448"},
    {young_of(4900.0, wet), wet, 1050.0,
     "shear modulus 4.9 +- 0.5 kPa at 45 Hz (9.4 +- 0.8 kPa at 76 Hz), 10 volunteers, in vivo, MR "
     "elastography",
     "Rouviere et al., J. Magn. Reson. Imaging 34 (2011) 880-886"},
    {young_of(3600.0, wet), wet, 1060.0,
     "shear stiffness 3.6 +- 0.3 kPa, 12 volunteers, in vivo, MR elastography",
     "Talwalkar et al., Am. J. Roentgenol. 193 (2009) 122-127"},
    {1650.0, wet, 1040.0,
     "white matter 1.895 +- 0.592 kPa, gray matter 1.389 +- 0.289 kPa, bovine, indentation; their mean",
     "Budday et al., J. Mech. Behav. Biomed. Mater. 46 (2015) 318-330"},
    {3250.0, wet, 950.0, "Young's modulus 3.25 +- 0.91 kPa, human breast fat, ex vivo, indentation",
     "Samani, Zubovits & Plewes, Phys. Med. Biol. 52 (2007) 1565-1576"},
    {22400.0, wet, 1050.0,
     "Young's modulus across the fibres 22.4 +- 14.7 kPa, along them 447 +- 98 kPa, rabbit, passive tension",
     "Morrow et al., J. Mech. Behav. Biomed. Mater. 3 (2010) 124-129"},
    {0.42e6, wet, 1100.0, "Young's modulus 0.42 MPa below 30 years, 0.85 MPa above, in vivo, torsion",
     "Agache et al., Arch. Dermatol. Res. 269 (1980) 221-232"},
    {1.8e6, wet, 1100.0, "posterior sclera 1.8 +- 1.1 MPa, anterior 2.9 +- 1.4 MPa, human, tension",
     "Friberg & Lace, Exp. Eye Res. 47 (1988) 429-436"},
    {1.2e9, wet, 1100.0, "Young's modulus 1.2 GPa at 25 MPa, human tibialis anterior, in vivo",
     "Maganaris & Paul, J. Physiol. 521 (1999) 307-313"},
    {0.64e6, 0.03, 1100.0,
     "aggregate modulus 0.64 +- 0.22 MPa, Poisson's ratio 0.03 +- 0.01, bovine humeral head, drained",
     "Soltz & Ateshian, J. Biomech. Eng. 122 (2000) 576-586"},
    {3.84e8, 0.3, 1180.0, "4730 rho^1.56 MPa, human vertebra, at the apparent density rho = 0.2 g/cm^3",
     "Morgan, Bayraktar & Keaveny, J. Biomech. 36 (2003) 897-904"},
    {17e9, 0.3, 1920.0, "Young's modulus 17.0 GPa along the bone, 11.5 GPa across it, human femur",
     "Reilly & Burstein, J. Biomech. 8 (1975) 393-405"},
}};

}  // namespace

const TissueInfo& tissue_info(Tissue tissue) {
  return infos.at(static_cast<std::size_t>(tissue));
}

Material tissue_material(Tissue tissue) {
  const TissueInfo& info = tissue_info(tissue);
  const bool stiff =
      tissue == Tissue::tendon || tissue == Tissue::trabecular_bone || tissue == Tissue::cortical_bone;
  Material material;
  material.young_modulus = info.young_modulus;
  material.poisson_ratio = info.poisson_ratio;
  material.density = info.density;
  material.model = stiff ? MaterialModel::corotational : MaterialModel::stable_neo_hookean;
  material.tissue = tissue;
  return material;
}

}  // namespace palpate

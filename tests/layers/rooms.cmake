# Which room may include which (beside itself), and which foreign headers a room may see.
# ARCHITECTURE.md, "Rooms", says why.
set(rooms geometry trajectory boundary fill winding analysis io/step io cli)

set(may_include_geometry)
set(may_include_trajectory geometry)
set(may_include_boundary trajectory geometry)
set(may_include_fill boundary trajectory geometry)
set(may_include_winding geometry)
set(may_include_analysis boundary fill winding trajectory geometry)
set(may_include_io/step geometry)
set(may_include_io io/step analysis winding fill boundary trajectory geometry)
set(may_include_cli io io/step analysis winding fill boundary trajectory geometry)

# Header families that stay behind a door: the pattern of the include, and the rooms that may use it.
set(families opencascade toml json cli11 cgal ceres)
set(pattern_opencascade "^(opencascade/)?(BRep|BSpl|BinTools|Bnd_|CPnts|CSLib|Convert_|Extrema_|GC|GCPnts|GProp|Geom|IFSelect|IGES|Interface_|IntAna|IntCurve|IntPatch|IntRes|IntTools|Law_|Message|NCollection|OSD|Poly_|Precision|Quantity|RWStl|STEP|ShapeA|ShapeB|ShapeC|ShapeE|ShapeF|ShapeP|ShapeU|Standard|StdPrs|StlAPI|Step[A-Z]|TColStd|TColgp|TCollection|TDF_|TDataStd|TDocStd|TopAbs|TopExp|TopLoc|TopTools|TopoDS|Transfer|UnitsAPI|UnitsMethods|XCAF|XSControl|XmlDrivers|gp_|gp\\.hxx|math_)[A-Za-z0-9_]*(\\.hxx|\\.h|\\.lxx)?$|\\.hxx$")
set(homes_opencascade io/step)
set(pattern_toml "^toml(\\.hpp|/)")
set(homes_toml io)
set(pattern_json "^nlohmann/")
set(homes_json io cli)
set(pattern_cli11 "^CLI/")
set(homes_cli11 cli)
set(pattern_cgal "^CGAL/")
set(homes_cgal geometry fill)
set(pattern_ceres "^ceres/")
set(homes_ceres trajectory)

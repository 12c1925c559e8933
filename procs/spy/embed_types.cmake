# cmake -D FILES=a.lcm;b.lcm -D OUT=x.cpp -P embed_types.cmake: the texts of the files as one C++ source that defines
# cairn::spy::embedded_files().
set(text "// Written by embed_types.cmake.\n#include \"procs/spy/embedded_types.hpp\"\n\nnamespace cairn::spy {\n\n")
string(APPEND text "std::vector<SchemaFile> embedded_files() {\n  return {\n")
foreach(file IN LISTS FILES)
  get_filename_component(name ${file} NAME)
  file(READ ${file} content)
  string(APPEND text "      {\"${name}\", R\"lcm(${content})lcm\"},\n")
endforeach()
string(APPEND text "  };\n}\n\n}  // namespace cairn::spy\n")
file(WRITE ${OUT} "${text}")

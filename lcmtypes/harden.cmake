# Makes one header that lcm-gen wrote safe on bad bytes: cmake -D IN=... -D OUT=... -P harden.cmake
#
# Decoding: lcm-gen resizes a vector to whatever the message says before it looks at how many bytes are left, and takes
# a string of length 0 apart. A guard goes before each: a count must be between 0 and the bytes that are left.
# Encoding: it walks as many elements as the count field says, however long the vector is. `counts_agree()` is added to
# every type and says whether all counts, nested ones too, equal the sizes of their vectors.
# tests/messages counts the guards in every generated header, so that another lcm-gen cannot slip past.
file(READ "${IN}" text)
string(REGEX REPLACE "(this->[A-Za-z0-9_]+(\\[a[0-9]+\\])*)\\.resize\\((this->[A-Za-z0-9_]+|[0-9]+)\\);"
  "if (static_cast<int64_t>(\\3) < 0 || static_cast<int64_t>(\\3) > static_cast<int64_t>(maxlen) - pos) return -1; \\1.resize(static_cast<size_t>(\\3));"
  text "${text}")
string(REGEX REPLACE "if\\((__[A-Za-z0-9_]+) > maxlen - pos\\) return -1;"
  "if (\\1 < 1 || \\1 > maxlen - pos) return -1;" text "${text}")

set(checks "")
string(REGEX MATCHALL "this->[A-Za-z0-9_]+\\.resize\\(static_cast<size_t>\\(this->[A-Za-z0-9_]+\\)\\)" resizes "${text}")
foreach(resize IN LISTS resizes)
  string(REGEX REPLACE "(this->[A-Za-z0-9_]+)\\.resize\\(static_cast<size_t>\\((this->[A-Za-z0-9_]+)\\)\\)"
    "            if (static_cast<int64_t>(\\1.size()) != static_cast<int64_t>(\\2)) return false;" check "${resize}")
  string(APPEND checks "${check}\n")
endforeach()
string(REGEX MATCHALL "this->[A-Za-z0-9_]+(\\[a0\\])?\\._decodeNoHash" nested "${text}")
foreach(field IN LISTS nested)
  if(field MATCHES "\\[a0\\]")
    string(REGEX REPLACE "\\[a0\\]\\._decodeNoHash" "" field "${field}")
    string(APPEND checks "            for (const auto& element : ${field}) if (!element.counts_agree()) return false;\n")
  else()
    string(REGEX REPLACE "\\._decodeNoHash" "" field "${field}")
    string(APPEND checks "            if (!${field}.counts_agree()) return false;\n")
  endif()
endforeach()
string(REPLACE "        // LCM support functions. Users should not call these"
  "        /// Whether every count field equals the size of its vector; a message is only encoded where it holds.
        inline bool counts_agree() const {
${checks}            return true;
        }

        // LCM support functions. Users should not call these" text "${text}")
file(WRITE "${OUT}" "${text}")

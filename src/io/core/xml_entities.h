// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace ovoid::io {

// The text of an XML file with the entities in place that its own DOCTYPE declares, as
// `<!ENTITY HeavyData "a.h5">`; what XML itself knows (&lt;, &#10;) stays. Entities within entities
// are followed 16 deep, and 2^24 bytes and references are put in at most. Throws Error that names
// the file and the entity: kFileFormat for one that is not declared, kUnsupported for one that lies
// in another file, or beyond these limits. Cost: nothing to speak of without an '&'.
std::string with_own_entities(const std::string& file, std::string text);

// What a file says, for a message: without the ends of lines that it may hold.
std::string in_one_line(std::string text);

}  // namespace ovoid::io

# SPDX-License-Identifier: Apache-2.0
# fish completion of ovoid, from what the program tells of itself (see ovoid.bash).

# A file in the command's place is for the viewer.
function __ovoid_command
    set -l words (commandline -opc)
    if contains -- $words[2] (ovoid --list-flags 2>/dev/null | cut -f1)
        echo $words[2]
    else
        echo view
    end
end

function __ovoid_flags
    ovoid (__ovoid_command) --list-flags 2>/dev/null | while read -d \t names form text
        for name in (string split , -- $names)
            printf '%s\t%s\n' $name $text
        end
    end
end

function __ovoid_choices
    set -l words (commandline -opc)
    ovoid (__ovoid_command) --list-flags 2>/dev/null | while read -d \t names form text
        if contains -- $words[-1] (string split , -- $names); and string match -qr '^[^A-Z]*\|[^A-Z]*$' -- $form
            string split '|' -- $form
        end
    end
end

complete -c ovoid -n __fish_use_subcommand -a '(ovoid --list-flags | cut -f1,3)'
complete -c ovoid -n 'not __fish_use_subcommand; and string match -q -- "-*" (commandline -ct)' -f -a '(__ovoid_flags)'
complete -c ovoid -n 'not __fish_use_subcommand; and test -n "(__ovoid_choices)"' -a '(__ovoid_choices)'

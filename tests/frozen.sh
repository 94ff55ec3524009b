#!/usr/bin/env bash
# Freezes what people and scripts rely on, and compares a later build with it: shows that moving and merging source files changed
# none of it.
#   tests/frozen.sh freeze DIR [--build]    writes the figures of this build into DIR, a text file for each subject
#   tests/frozen.sh compare DIR [--build]   makes them again, and prints what differs. Exit code: 0 the same, 6 something differs
# It reads the release build (./run build), or the build folder TOUCHABLE_BUILD, and depends on no source file's place. --build also
# measures the CPU time of a clean build and of a rebuild, in a copy (tens of minutes).
set -euo pipefail

die() { printf 'frozen.sh: %s\n' "$*" >&2; exit 2; }

(($# == 2)) || [[ $# == 3 && $3 == --build ]] || die "usage: frozen.sh freeze|compare DIR [--build]"
[[ $1 == freeze || $1 == compare ]] || die "'$1' is neither freeze nor compare"
dir=$(realpath -m "$2")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
root=$PWD
build=$(realpath -m "${TOUCHABLE_BUILD:-build/release}")
touchable=$build/player/touchable
subjects=(bytes forces recordings interface libraries python instructions tests)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# The user's settings, caches, display and language make no difference.
export LC_ALL=C XDG_CACHE_HOME=$work/home XDG_CONFIG_HOME=$work/home XDG_DATA_HOME=$work/home XDG_STATE_HOME=$work/home
unset DISPLAY WAYLAND_DISPLAY
mkdir "$work/home" "$work/files"

# Whether ninja has nothing to do for files of the build folder, by a copy of its file without the search for new source files,
# which a dry run takes for work to do.
up_to_date() {
    sed '/^build .*[vV]erify_\?[gG]lobs[^ ]*:/,/^$/d' "$build/build.ninja" >"$work/build.ninja"
    ninja -C "$build" -f "$work/build.ninja" -n build.ninja "${@#"$build/"}" 2>&1 | grep -q 'no work to do'
}
check_build() {
    [[ -x $touchable ]] || die "$touchable does not exist; ./run build makes it"
    up_to_date "$touchable" "$build"/*/libtouchable{,-media}.so || die "$build is older than its sources; ./run build makes it anew"
    mapfile -t test_programs < <(find "$build/tests" -name 'test_*' -type f -executable)
    up_to_date "${test_programs[@]}" || echo "frozen.sh: warning: test programs are older than their sources, so their names may be, too" >&2
}

# Runs the program without its texts. Where it fails, a line has its exit code.
quiet() {
    local code=0
    "$touchable" "$@" </dev/null >/dev/null 2>&1 || code=$?
    ((code == 0)) || echo "exit code $code: $*"
}

# numbers NAME: of the JSON on standard input numbers and force hash, but for what a clock measured. keys NAME: its keys.
json() {
    python3 -c '
import json, sys
wanted, name = sys.argv[1:]
def leaves(value, path):
    if isinstance(value, dict):
        for key, inner in value.items():
            if wanted == "keys" or key not in ("tick_us", "frame_ms", "stages_ms"):
                yield from leaves(inner, f"{path}.{key}")
    elif isinstance(value, list) and (wanted == "numbers" or any(isinstance(each, (dict, list)) for each in value)):
        for inner in value:
            yield from leaves(inner, path + "[]")
    elif wanted == "keys":
        yield f"{name}: {path}"
    elif not isinstance(value, str) or path == ".force_hash":
        yield f"{name}: {path} {value}"
print(*sorted(set(leaves(json.load(sys.stdin), ""))), sep="\n")' "$@"
}

# What the program writes, of which each run gives the same bytes but for what is masked. Left out: what a live run or a window writes
# (recordings, logs, sound, films), as its ticks and pictures depend on the wall clock; plots, which matplotlib draws; reports, whose keys
# and numbers are other subjects.
bytes() {
    local scene painter
    for scene in globe bumps rough moving plane spheres step noise cliffs grain; do
        quiet make $scene $scene.mkv --size 96x64 --frames 4
    done
    quiet make globe bits8.mkv --size 96x64 --frames 4 --bits 8 --plain --preset A
    quiet make globe small.mkv --size 96x64 --frames 4 --bits 12 --archive small --exact-colour
    quiet make globe sent.mp4 --size 96x64 --frames 4
    quiet make globe pieces.mp4 --size 96x64 --frames 40 --fragmented
    quiet convert globe.mkv folder/
    quiet convert globe.mkv one.png --from 1
    quiet convert globe.mkv scene.gltf
    quiet convert globe.mkv text.bt --from 1
    quiet convert globe.mkv still.mp4 --still --from 1
    quiet convert globe.mkv lerobot.mp4 --lerobot --allow-lossy
    quiet convert globe.mkv part.mkv --from 1 --every 2 --crop 8,8,64x48 --size 32x24 --allow-lossy
    quiet export globe.mkv --frame 1 --out frame
    quiet export globe.mkv --frames all --mesh --out frames --filters off
    quiet export noise.mkv --frame 1 --out filtered --median 5 --fill-holes 4 --temporal 0.0001 --terraces on
    quiet make globe wide.mkv --size 128x64 --frames 1
    quiet export wide.mkv --frame 0 --out maps
    quiet make globe maps.mkv --size 96x64 --frames 2 --colour maps/colour.png --elevation maps/depth.png
    quiet relief globe.mkv relief.mkv
    quiet materials globe.mkv materials.mkv --otherwise wood --scale-relief --save segments.json
    quiet materials globe.mkv materials.png --otherwise rubber --frame 1
    quiet init-scene folder --out pictures.json
    quiet init-scene globe.mkv --out packed.json
    quiet init-scene maps/depth.png --out picture.json --fov 70 --preset tum
    cp "$root/tests/data/clip_t3dz.mkv" .
    quiet convert clip_t3dz.mkv first_version/
    "$touchable" info globe.mkv --scene-text >scene_text.txt || true
    "$touchable" devices --udev-rules | grep -v '^#' >udev.rules || true
    quiet touch globe.mkv --fingers 2 --seconds 0.5 --forces forces.csv --record run.rec
    quiet touch globe.mkv --fingers 2 --seconds 0.5 --forces pixel_forces.csv --metric pixel
    # A touched scene as each painter draws it; mesh and raster by the software Vulkan.
    for painter in cpu raster mesh; do
        quiet touch globe.mkv --seconds 0.5 --picture picture_$painter.png --picture-size 320x200 --painter $painter --gpu cpu
    done
    quiet serve globe.mkv --hls hls --hls-low on --json serve.json
    # A stream's name in its files is drawn by chance, and each frame says when it was taken.
    python3 - <<'END'
import os, pathlib, re
for file in sorted(pathlib.Path("hls").glob("*")):
    data = file.read_bytes()
    if file.suffix == ".m3u8":
        data = re.sub(rb"(DATE-TIME:).*", rb"\1", re.sub(rb"-[0-9a-f]{8}-", b"-", data))
    data = re.sub(rb"taken_ns=\d+ xxh64=\w+", b"", data)
    os.makedirs("hls_masked", exist_ok=True)
    pathlib.Path("hls_masked", re.sub("-[0-9a-f]{8}-", "-", file.name)).write_bytes(data)
END
    find . -type f ! -path './hls/*' ! -name serve.json -printf '%P\0' | xargs -0 sha256sum | awk '{print $2, $1}'
}

# Figures of runs, as the JSON report has them, by the CPU's builder unless another one is named.
forces() {
    local words
    quiet make globe large.mkv --size 240x160 --frames 12 --bits 16
    quiet make globe coarse.mkv --size 160x120 --frames 12 --bits 8 --preset A
    quiet make plane tilted.mkv --size 64x48 --frames 2 --tilt 40 --tilt-direction 30
    tr '|' '\n' <<'END' | while read -r words; do
large.mkv | large.mkv --builder reference --fingers 5 | large.mkv --builder lazy --fingers 10
large.mkv --builder vulkan --gpu cpu --fingers 5 --median 3 --fill-holes 3
large.mkv --rate 0.5 --start 0.1 --stiffness-slew 5 --max-force 2 | large.mkv --builder lazy --loop 0.05 0.3 --interpolation hold
coarse.mkv --terraces on --fingers 5 | coarse.mkv --builder vulkan --gpu cpu --terraces on --median 5
coarse.mkv --builder lazy --filters auto | bumps.mkv --hand stroke --median 5 | rough.mkv --hand press --max-stiffness 1
moving.mkv --hand stroke --temporal 0.2 --fingers 5 | tilted.mkv --hand stroke --stiffness passive --damping 0.5 --passivity 1
tilted.mkv --hand poke --metric pixel | spheres.mkv --hand stroke --metric scaled | step.mkv --hand stroke --stribeck 0.05
noise.mkv --median 3 --temporal 0.0001 | cliffs.mkv --builder lazy --fill-holes 16 --fingers 5 | grain.mkv --filters off | bits8.mkv
sent.mp4 | pieces.mp4 | still.mp4 | lerobot.mp4 --filters off | folder | one.png | scene.gltf | text.bt | hls/master.m3u8
maps/depth.png --fov 70 --depth-unit 0.000002 | relief.mkv --hand stroke | materials.mkv --hand stroke
END
        [[ $words == *--builder* ]] || words+=' --builder cpu'
        rm -f report.json
        # shellcheck disable=SC2086
        quiet touch $words --seconds 0.8 --json report.json
        [[ ! -e report.json ]] || json numbers "$words" <report.json
    done
}

# What the program of the freeze recorded is in DIR/recorded, with its clip: this program repeats it to the bit, or the exit code is not 0.
record() {
    rm -rf "$dir/recorded"
    mkdir "$dir/recorded"
    cd "$dir/recorded"
    quiet make moving clip.mkv --size 96x64 --frames 30
    printf '0.1 pause\n0.2 step\n0.3 seek 0.5\n0.4 play\n0.5 rate 0.25\n0.6 loop 0.2 0.5\n0.9 unloop\n' >play.txt
    printf '0 move 160 100\n0.2 press left\n0.4 move 200 110\n0.6 seek 0.5\n0.9 release left\n1 quit\n' >inputs.txt
    quiet touch clip.mkv --fingers 5 --seconds 1 --record five.rec
    quiet touch clip.mkv --hand stroke --median 3 --temporal 0.2 --seconds 1 --record filtered.rec
    quiet touch clip.mkv --hand stroke --play play.txt --seconds 1.2 --record clock.rec
    quiet touch clip.mkv --hand stroke --live --device simulated --seconds 0.6 --record live.rec
    quiet play clip.mkv --headless --size 320x200 --script inputs.txt --record window.rec
}
recordings() {
    local file code
    quiet make moving v1.mkv --size 32x24 --frames 3
    # It was made under older rules of force: it is read and its hand is given, but forces are not compared (exit code 3).
    cp "$root/tests/data/recording_v1.rec" v1.rec
    quiet touch v1.mkv --replay v1.rec --forces v1.csv
    sha256sum v1.csv
    for file in "$dir"/recorded/*.rec; do
        code=0
        (cd "$dir/recorded" && "$touchable" touch --replay "$file") >/dev/null 2>&1 || code=$?
        echo "${file##*/}: exit code $code"
    done
}

interface() {
    local command words code
    "$touchable" --help | sed -n '/^Subcommands/,$ s/^  \([a-z-]*\) .*/\1/p' >commands.txt
    sed 's/^/command /' commands.txt
    # Names of options and of what follows them, with defaults, and what excludes or needs what; no texts.
    for command in '' $(<commands.txt); do
        "$touchable" ${command:+"$command"} --help | python3 -c '
import re, sys
for line in sys.stdin:
    if found := re.match(r"  (?:-\S+|[A-Z]+)(?: [A-Z](?![a-z])\S*| x \d+| \.\.\.)*(?: (?:Excludes|Needs):(?: --[\w-]+)+)*(?= |$)", line.rstrip()):
        print("option", sys.argv[1], found[0].strip())' "$command"
    done
    "$touchable" formats | sed -nE 's/^(  [a-z0-9-]+|      touchable .*)(  .*|$)/formats: \1/p'
    "$touchable" devices | sed -nE '/^ +touchable /!s/^    ([a-z0-9:=A-Z]+) .*/devices: \1/p'
    "$touchable" materials --list | awk '/N\/mm  /{print "materials:", $1, $2, $4, $5, $6}'

    printf 'no clip' >text.mkv
    : >empty.mkv
    head -c 9000 globe.mkv >cut.mkv
    mkdir nothing
    tr '|' '\n' <<'END' | while read -r words; do
--version | --help | --nothing | nothing | missing.mkv | touch | touch missing.mkv | touch empty.mkv | touch text.mkv
touch cut.mkv --seconds 0.1 | touch nothing | touch globe.mkv --fingers 0 | touch globe.mkv --median 4 | touch globe.mkv --hand nothing
touch globe.mkv --rate 0 | touch globe.mkv --device simulated | touch globe.mkv --live --device falcon | touch globe.mkv --json globe.mkv
touch globe.mkv --replay text.mkv | touch globe.mkv --builder vulkan --gpu 99 | touch globe.mkv --seconds 0.01 --strict
touch tcp://127.0.0.1:1 | make nothing x.mkv | make globe x.mkv --size 0x0 | make globe x.avi | make globe globe.mkv
make globe missing/folder/x.mkv | play globe.mkv | play globe.mkv --headless | info missing.mkv | info globe.mkv --verify
export globe.mkv --frame 99 --out x | export globe.mkv | convert globe.mkv x.bmp | convert globe.mkv x.png
serve globe.mkv ftp://127.0.0.1 | compare forces.csv forces.csv | compare forces.csv pixel_forces.csv | compare forces.csv text.mkv
plot text.mkv x.png | plot forces.csv plot.png | check --device nothing | check --size 10 | devices --json --udev-rules | init-scene text.mkv
materials globe.mkv x.mkv --otherwise nothing | relief globe.mkv x.mkv --fine 900
END
        code=0
        # shellcheck disable=SC2086
        timeout 20 "$touchable" $words </dev/null >/dev/null 2>&1 || code=$?
        echo "exit code $code: $words"
    done

    quiet touch globe.mkv --builder lazy --seconds 0.2 --json lazy.json
    quiet touch globe.mkv --builder vulkan --gpu cpu --seconds 0.2 --json vulkan.json
    quiet touch globe.mkv --live --device simulated --hand stroke --seconds 0.3 --json live.json
    printf '0 median 5\n0.1 volume 20\n0.3 continue\n0.6 continue\n1 quit\n' >words.txt
    quiet play globe.mkv --headless --size 320x200 --script words.txt --settings settings.json
    for file in report lazy vulkan live serve settings; do json keys $file <$file.json; done
    "$touchable" info globe.mkv --json | json keys info
    "$touchable" info noise.mkv --json --verify | json keys info_verify
    "$touchable" check --json | json keys check
    "$touchable" compare forces.csv pixel_forces.csv --json | json keys compare
    "$touchable" devices --json | json keys devices

    quiet play globe.mkv --headless --size 320x200 --seconds 0.5 --kiosk --use-log use.csv
    mkdir results
    quiet play globe.mkv --headless --size 1280x720 --script words.txt --kiosk --study paper-4.2 --results results
    python3 -c 'print("time_s,finger,x,y,z,buttons", *(f"{t / 1000},0,0,0,{-t * 1e-4},0" for t in range(400)), sep="\n")' >hand.csv
    quiet touch globe.mkv --live --device recorded:hand.csv --device-log device.csv --seconds 0.2
    for file in forces use device results/*; do file=$(ls "${file%.csv}.csv") && echo "$file: $(head -n 1 "$file")"; done
}

# What is installed. Headers of the solver in C++ are not frozen: they move with the sources.
libraries() {
    local name file
    # Without the list of what was installed, which would go into the build folder.
    sed 's/^file(WRITE .*INSTALL_MANIFEST.*/message(VERBOSE/' "$build/cmake_install.cmake" >install.cmake
    cmake -DCMAKE_INSTALL_PREFIX="$PWD/installed" -P install.cmake >/dev/null 2>&1 || echo "cmake --install fails"
    (cd installed && find . ! -type d ! -path './include/touchable/*' ! -path './share/doc/*' ! -name 'libtouchable_*.a' -printf 'installed %P\n')
    for name in touchable.h touchable.hpp; do
        find installed/include -name $name | while read -r file; do
            echo "text of $name: $(g++ -w -x c++ -fpreprocessed -dD -E -P "$file" | sha256sum | cut -d' ' -f1)"
        done
    done
    for name in libtouchable.so libtouchable-media.so; do
        nm -D --defined-only "installed/lib/$name" | awk -v name=$name '{print name, "exports", $2, $3}'
        readelf -d "installed/lib/$name" | sed -nE "s/.*\((NEEDED|SONAME)\).*\[(.*)\]/$name \1 \2/p"
    done
    grep -rhoE '^ *add_library\(touchable::[a-z_]+ [A-Z]+' installed/lib/cmake | sed 's/.*(/target /'
    for file in installed/lib/pkgconfig/*.pc; do sed "s,^,${file##*/}: ," "$file"; done
}

# Names and signatures of the Python package, and what it reads, writes and feels by the libraries of the build.
python() {
    PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=$(dirname "$(dirname "$root/$(git -C "$root" ls-files '*touchable/__init__.py' | head -n 1)")") \
        LD_LIBRARY_PATH=$PWD/installed/lib /usr/bin/python3 - <<'END'
import enum, hashlib, inspect, numpy, touchable
def told(name, value):
    value = getattr(value, "__func__", value)
    if inspect.isclass(value) or callable(value):
        try:
            print(name + str(inspect.signature(value)))
        except ValueError:
            print(name, "class")
    else:
        print(name, repr(value) if isinstance(value, (int, str, float)) else type(value).__name__)
for name in touchable.__all__:
    value = getattr(touchable, name)
    told(name, value)
    if inspect.isclass(value):
        print(name, "bases", *(base.__name__ for base in value.__mro__[1:]))
        members = value.__members__.items() if issubclass(value, enum.Enum) else inspect.getmembers_static(value)
        for member, inner in members:
            if not member.startswith("_") or (member.startswith("__") and (getattr(inner, "__module__", "") or "").startswith("touchable")):
                told(f"{name}.{member}", inner)

def hashed(*arrays):
    return hashlib.sha256(b"".join(numpy.ascontiguousarray(array).tobytes() for array in arrays)).hexdigest()
frames = list(touchable.open("globe.mkv"))
print("depth, metres and colour of globe.mkv", *(hashed(*(getattr(frame, part) for frame in frames)) for part in ("depth", "metres", "colour")))
def codes(x, y):
    return 800 + 3 * x + (y - 24) ** 2 / 4
depth = codes(*numpy.meshgrid(numpy.arange(64), numpy.arange(48))).astype(numpy.uint16)
camera = touchable.Camera(64, 48, fx_px=60)
touchable.write("python.mkv", [depth, depth + 5], camera=camera)
with open("python.mkv", "rb") as file:
    print("python.mkv", hashlib.sha256(file.read()).hexdigest())
x = numpy.linspace(5, 58, 1500)
path = camera.points(x, 24 + x / 10, codes(x, 24 + x / 10) / 1000 - 0.005 * numpy.cos(x / 2))
surface = touchable.Surface(depth, camera)
touched = surface.touch(path, metres_per_scene_unit=1)
print("forces of a path", touched.force_hash, abs(touched.force_n).max(), "of places", hashed(surface.forces_at(path).force_n))
END
}

# Instructions of a tick and of a frame: by how many two runs differ, of which one has more ticks or more frames.
per() {  # count less more option...
    local run
    for run in "$2" "$3"; do
        # shellcheck disable=SC2086
        valgrind --tool=callgrind --callgrind-out-file=/dev/null "$touchable" touch $run "${@:4}" 2>&1 >/dev/null |
            awk '/Collected/{print $4}' >"count of $run" &
    done
    wait
    echo $((($(<"count of $3") - $(<"count of $2")) / $1))
}
instructions() {
    command -v valgrind >/dev/null || return 0
    local fingers ticks=("tick.mkv --seconds 0.5" "tick.mkv --seconds 1.5") frames=("few.mkv --seconds 0.7" "many.mkv --seconds 0.7")
    quiet make bumps tick.mkv --size 96x64 --frames 1
    quiet make globe few.mkv --size 160x120 --frames 4
    quiet make globe many.mkv --size 160x120 --frames 20
    for fingers in 1 5; do
        echo "tick, fingers $fingers: $(per 1000 "${ticks[@]}" --builder cpu --filters off --hand stroke --fingers $fingers)"
    done
    echo "frame: $(per 16 "${frames[@]}" --builder cpu --filters off)"
    echo "frame, filtered: $(per 16 "${frames[@]}" --builder cpu --median 5 --fill-holes 4 --terraces on --temporal 0.2)"
    echo "frame, lazy: $(per 16 "${frames[@]}" --builder lazy --filters off)"
}

# So that no test is lost; which program has it may change.
tests() {
    local program
    for program in "${test_programs[@]}"; do
        "$program" --gtest_list_tests | awk '/^[^ ].*\.( |$)/{suite = $1} /^  /{print suite $1}'
    done
}

# Structure of the code, where the tool is that counts it; only told.
house() { cd "$root" && if [[ -x ../shared/tools/house-figures ]]; then ../shared/tools/house-figures; fi; }

# CPU time of a clean build and of a rebuild, in a copy of what git tracks, without ccache; only told.
cpu_time() { { time cmake --build --preset release >/dev/null 2>&1 || echo 'the build fails'; } 2>&1; }
build_times() {
    local scene TIMEFORMAT='%U s user, %S s system'
    mkdir "$work/copy"
    (cd "$root" && git ls-files -z | xargs -0 cp --parents -P -t "$work/copy")
    cd "$work/copy"
    export CCACHE_DISABLE=1
    cmake --preset release >/dev/null
    echo "clean build: $(cpu_time)"
    scene=$(git -C "$root" ls-files '*scene.hpp' | grep -E '^engine/(.*/)?scene\.hpp$' | head -n 1)
    touch "$scene"
    echo "rebuild after $scene: $(cpu_time)"
}

# All figures into a folder. Some subjects read files that those before them made. What fails in one is a difference, not the end.
figures() {
    local subject
    for subject in "${subjects[@]}" house ${1:+build_times}; do
        (set +e; cd "$work/files" && "$subject"; true) | if [[ $subject == house ]]; then cat; else sort; fi >"$2/$subject.txt"
    done
}

check_build
if [[ $1 == freeze ]]; then
    mkdir -p "$dir"
    (record)
    figures "${3:-}" "$dir"
    wc -l "$dir"/*.txt
    exit
fi
[[ -d $dir/recorded ]] || die "$dir holds no figures; frozen.sh freeze $dir writes them"
mkdir "$work/now"
figures "${3:-}" "$work/now"
different=0
for subject in "${subjects[@]}"; do
    now=$work/now/$subject.txt
    if [[ $subject == instructions ]]; then
        if [[ ! -s $now || ! -s $dir/instructions.txt ]]; then
            echo "instructions: left out, as valgrind is not installed, or was not when they were frozen"
            continue
        fi
        # A count within 2 % is the same.
        awk -F': ' 'NR == FNR {old[$1] = $2; next} $1 in old && ($2 - old[$1])^2 <= (0.02 * old[$1])^2 {$2 = old[$1]} {print $1 ": " $2}' \
            "$dir/instructions.txt" "$now" >"$work/near.txt"
        now=$work/near.txt
    fi
    if found=$(diff "$dir/$subject.txt" "$now" 2>&1); then
        echo "$subject: the same"
    else
        different=$((different + 1))
        echo "$subject: differs in $(grep -c '^[<>]' <<<"$found" || true) lines"
        head -n 20 <<<"$found"
    fi
done
for subject in house ${3:+build_times}; do
    echo "$subject, frozen and now:"
    diff --side-by-side --width 160 --expand-tabs "$dir/$subject.txt" "$work/now/$subject.txt" || true
done
if ((different)); then echo "$different subjects differ"; exit 6; fi
echo "the same"

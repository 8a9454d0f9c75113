#!/usr/bin/env bash
# make_files.sh ANTUMBRA FOLDER: the scenes and baked files that the tests of the JavaScript package use.
set -euo pipefail
antumbra=$1
folder=$2
mkdir -p "$folder"
cd "$folder"
"$antumbra" generate town -o town.glb --triangles 50000
"$antumbra" bake town.glb -o town.pvs --cell-size 16 --rays-per-cell 2048 --holdout-rays 64 --volumes 8x4x8
"$antumbra" bake town.glb -o tree.pvs --subdivision five --max-depth 6 --rays-per-cell 1024 --holdout-rays 64
# Proved, so that not one pixel may be missing: two cells of the square.
echo '[{"min":[0,1.2,-1],"max":[4,2.2,1]}]' >where.json
"$antumbra" bake town.glb -o square.pvs --method exact --cell-size 2 --where where.json
# Clusters of triangles, in the leaves of a tree.
"$antumbra" generate apartment -o flat.glb
echo '[{"min":[1,1,1],"max":[2,2,2]},{"min":[4,1,2],"max":[5,2,3]}]' >rooms.json
"$antumbra" bake flat.glb -o clusters.pvs --method exact --subdivision boxes --where rooms.json --rays-per-cell 1024 \
  --granularity cluster --cluster-triangles 4

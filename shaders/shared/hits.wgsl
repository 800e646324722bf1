// The list of hits that every search appends to. Twin: `GpuHits` in src/backend/gpu/hits.rs.
// Writes the buffer `hits` of the kernel that imports it, and the first of its `counts`: the hits in the list.
#import hit

// Appends a hit. What the list cannot hold is counted all the same.
fn append(hit: Hit) {
    let index = atomicAdd(&counts[0], 1u);
    if index < arrayLength(&hits) {
        hits[index] = hit;
    }
}

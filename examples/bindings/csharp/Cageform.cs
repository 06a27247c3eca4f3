// Packed figures in C# 7, for Unity and mono: open, clone, play clips, pose by pins. This file calls the C interface of the
// shared library (include/cageform/c/cageform.h). It allocates no memory per frame and has no unsafe code.
//
// Points are 3D in float: x y z each, in arrays or at addresses. Errors of the library throw a CageformException. Arrays that are
// too short throw an ArgumentException. Several threads may use a Figure at once; only one at a time may use a
// Player or Pins.
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Cageform
{
    /// An error status of the library.
    public sealed class CageformException : Exception
    {
        /// The code of the status, which never changes, and its name, such as "blob_corrupt".
        public readonly int Code;
        public readonly string Name;
        /// The invalid element: the index of a pin or handle, or the four letters of the part of a file; null if there is none.
        public readonly string Culprit;

        internal CageformException(int code, string culprit = null, string message = null)
            : base(message ?? Native.Text(Native.cageform_status_text(code)))
        {
            Code = code;
            Name = Native.Text(Native.cageform_status_name(code));
            Culprit = culprit;
        }
    }

    /// A packed figure: a file written by bind_mesh, the Python or npm package, or cageform_pack.
    public sealed class Figure : IDisposable
    {
        internal readonly Handle Handle;
        public readonly int Points, Handles, Clips, Levels;
        /// Number of handles that are vertices of the cage: the size of clips and of the input of PoseHandles.
        public readonly int Vertices;
        public readonly bool HasNormals, HasTangents;
        /// The origin x, y, z of the coordinates of points, handles and clips. Add it to clones in double precision.
        public readonly double[] Origin;

        /// Opens a packed figure. Copies the bytes.
        public Figure(byte[] bytes) : this(Open(bytes)) { }

        Figure(Handle handle)
        {
            Handle = handle;
            var info = new Native.FigureInfo { size = Native.SizeOf<Native.FigureInfo>() };
            int code = Native.cageform_figure_describe(handle, ref info);
            if (code == 0 && info.scalar != Native.Float) code = Native.ScalarDiffers;
            if (code == 0 && info.dimension != 3) code = Native.DimensionDiffers;
            if (code != 0)
            {
                handle.Dispose();
                throw new CageformException(code);
            }
            Points = checked((int)info.points);
            Handles = checked((int)info.handles);
            Vertices = checked((int)info.vertices);
            Clips = checked((int)info.clips);
            Levels = checked((int)info.levels);
            HasNormals = info.has_normals != 0;
            HasTangents = info.has_tangents != 0;
            Origin = info.origin;
        }

        static Handle Open(byte[] bytes)
        {
            var memory = new AlignedBytes(bytes);
            Handle handle;
            UIntPtr part;
            int code = Native.cageform_open(memory.Data, memory.Size, IntPtr.Zero, out handle, out part);
            if (code == 0) return handle.Keep(memory);
            memory.Free();
            ulong tag = (ulong)part;
            if (tag == 0 || tag > uint.MaxValue) throw new CageformException(code);
            string name = Encoding.ASCII.GetString(BitConverter.GetBytes((uint)tag));
            throw new CageformException(code, name, Native.Text(Native.cageform_status_text(code)) + " (part " + name + ")");
        }

        /// Opens a level of less detail, for the same poses; level 0 is the figure itself.
        public Figure Level(int level)
        {
            Handle handle;
            Native.Check(Native.cageform_open_level(Handle, Native.Index(level, "level"), IntPtr.Zero, out handle));
            return new Figure(handle.Keep(Handle));
        }

        /// Writes the handles at rest, the initial pose: 3 * Handles numbers.
        public void Rest(float[] pose)
        {
            using (var to = new Pinned(pose, 3, Handles, "pose"))
                Native.Check(Native.cageform_figure_rest(Handle, to.View));
        }

        /// Deforms the figure by a pose of all handles. Tangents, or normals and tangents, may be null. Tangents are x y z w
        /// each; w is the handedness.
        public void Clone(float[] pose, float[] points, float[] normals = null, float[] tangents = null)
        {
            using (var from = new Pinned(pose, 3, Handles, "pose"))
            using (var to = new Pinned(points, 3, Points, "points"))
            using (var turned = normals == null ? default(Pinned) : new Pinned(normals, 3, Points, "normals"))
            using (var along = tangents == null ? default(Pinned) : new Pinned(tangents, 4, Points, "tangents"))
                Clone(from.Address, to.Address, turned.Address, along.Address);
        }

        /// As above, with addresses, such as those of GetUnsafePtr of NativeArray: a pose of Handles points, and memory for
        /// Points points, normals, tangents. Tangents, or normals and tangents, may be IntPtr.Zero. A wrong address, or
        /// memory that is too short, crashes the program.
        public void Clone(IntPtr pose, IntPtr points, IntPtr normals, IntPtr tangents)
        {
            Native.Points from = Pinned.ViewOf(pose, 3, Handles), to = Pinned.ViewOf(points, 3, Points);
            Native.Points turned = Pinned.ViewOf(normals, 3, Points), along = Pinned.ViewOf(tangents, 4, Points);
            int code;
            if (normals == IntPtr.Zero && tangents == IntPtr.Zero)
                code = Native.cageform_clone(Handle, from, to, IntPtr.Zero, IntPtr.Zero, IntPtr.Zero);
            else if (tangents == IntPtr.Zero)
                code = Native.cageform_clone(Handle, from, to, ref turned, IntPtr.Zero, IntPtr.Zero);
            else
                code = Native.cageform_clone(Handle, from, to, ref turned, ref along, IntPtr.Zero);
            Native.Check(code);
        }

        /// Computes a pose of all handles from a pose of the cage's vertices. Green coordinates need it.
        public void PoseHandles(float[] vertices, float[] handles)
        {
            using (var from = new Pinned(vertices, 3, Vertices, "vertices"))
            using (var to = new Pinned(handles, 3, Handles, "handles"))
                Native.Check(Native.cageform_pose_handles(Handle, from.View, to.View));
        }

        /// Returns the label of a handle; empty if it has none.
        public string Label(int handle)
        {
            IntPtr text;
            UIntPtr length;
            Native.Check(Native.cageform_figure_label(Handle, Native.Index(handle, "handle"), out text, out length));
            var bytes = new byte[(int)length];
            if (bytes.Length > 0) Marshal.Copy(text, bytes, 0, bytes.Length);
            return Encoding.UTF8.GetString(bytes);
        }

        /// Returns the first handle with a label; -1 if there is none.
        public int FindHandle(string label)
        {
            byte[] text = Encoding.UTF8.GetBytes(label);
            UIntPtr handle;
            Native.Check(Native.cageform_figure_find_handle(Handle, text, (UIntPtr)text.Length, out handle));
            return (ulong)handle < (ulong)Handles ? (int)handle : -1;
        }

        /// Creates a player of a clip, given by name. Create one player per playing character.
        public Player Play(string name)
        {
            byte[] text = Encoding.UTF8.GetBytes(name);
            UIntPtr clip;
            Native.Check(Native.cageform_figure_find_clip(Handle, text, (UIntPtr)text.Length, out clip));
            if ((ulong)clip >= (ulong)Clips) throw new ArgumentException("the figure has no clip " + name, "name");
            Handle handle;
            Native.Check(Native.cageform_play(Handle, clip, IntPtr.Zero, out handle));
            return new Player(handle.Keep(Handle));
        }

        public void Dispose() { Handle.Dispose(); }
    }

    /// Plays a clip, the motion of a cage's vertices.
    public sealed class Player : IDisposable
    {
        readonly Handle handle;
        public readonly int Vertices;
        public readonly double Begin, End;

        internal Player(Handle handle)
        {
            this.handle = handle;
            var info = new Native.ClipInfo { size = Native.SizeOf<Native.ClipInfo>() };
            Native.Check(Native.cageform_player_describe(handle, ref info));
            Vertices = checked((int)info.vertices);
            Begin = info.begin;
            End = info.end;
        }

        /// Writes the cage's vertices at a time: 3 numbers each.
        public void Sample(double time, float[] vertices)
        {
            using (var to = new Pinned(vertices, 3, Vertices, "vertices"))
                Native.Check(Native.cageform_player_sample(handle, time, to.View));
        }

        public void Dispose() { handle.Dispose(); }
    }

    /// Moves a cage so that pinned points reach targets and its interior deforms as rigidly as possible.
    public sealed class Pins : IDisposable
    {
        readonly Handle handle;
        readonly IntPtr report;
        int pins;
        public readonly int Handles;

        /// Opens packed samples of the cage. Copies the bytes.
        ///   pinWeight   stiffness of a pin of weight 1 relative to the stretch of the figure; 0: 1e4
        ///   hard        pins are a thousand times nearer to their targets
        ///   iterations  per call of Solve; 0: 4
        public Pins(byte[] samples, double pinWeight = 0, bool hard = false, int iterations = 0)
        {
            var memory = new AlignedBytes(samples);
            Handle opened = null;
            try
            {
                Native.Check(Native.cageform_samples_open(memory.Data, memory.Size, 0, out opened));
                var info = new Native.SamplesInfo { size = Native.SizeOf<Native.SamplesInfo>() };
                Native.Check(Native.cageform_samples_describe(opened, ref info));
                if (info.scalar != Native.Float) throw new CageformException(Native.ScalarDiffers);
                if (info.dimension != 3) throw new CageformException(Native.DimensionDiffers);
                Handles = checked((int)info.handles);
                var options = new Native.PinsOptions { size = Native.SizeOf<Native.PinsOptions>(), pin_weight = pinWeight,
                                                       hard = hard ? 1 : 0, iterations = Native.Index(iterations, "iterations") };
                Native.Check(Native.cageform_pins_create(opened, ref options, out handle));
            }
            finally
            {
                if (opened != null) opened.Dispose();
                memory.Free();
            }
            var room = new AlignedBytes((int)Native.SizeOf<Native.Report>());
            handle.Keep(room);
            report = room.Data;
            Marshal.WriteIntPtr(report, (IntPtr)(int)Native.SizeOf<Native.Report>());
        }

        /// Replaces all pins by pins at points of a figure, given by index. Weights may be null: all are 1.
        public void Set(Figure figure, int[] points, double[] weights = null)
        {
            if (weights != null && weights.Length != points.Length) throw new ArgumentException("one weight per pin is needed", "weights");
            Check(Native.cageform_pins_set(handle, figure.Handle, points, (UIntPtr)points.Length, weights, report));
            pins = points.Length;
        }

        /// Replaces the set of fixed handles, which keep their positions in the pose.
        public void Hold(int[] handles)
        {
            Check(Native.cageform_pins_hold(handle, handles, (UIntPtr)handles.Length, report));
        }

        /// Moves a pose of all handles towards the targets, one per pin. Call it once per frame until it returns true:
        /// the pose has settled.
        public bool Solve(float[] targets, float[] pose)
        {
            using (var from = new Pinned(targets, 3, pins, "targets"))
            using (var to = new Pinned(pose, 3, Handles, "pose"))
                Check(Native.cageform_pins_solve(handle, from.View, to.View, report));
            return Marshal.ReadInt32(report, settled) != 0;
        }

        /// The largest distance of a pin from its target in the last frame.
        public double Miss { get { return BitConverter.Int64BitsToDouble(Marshal.ReadInt64(report, miss)); } }

        static readonly int settled = Native.OffsetOf("settled"), miss = Native.OffsetOf("miss");
        static readonly int culprit = Native.OffsetOf("culprit"), message = Native.OffsetOf("message");

        void Check(int code)
        {
            if (code == 0) return;
            ulong named = (ulong)Marshal.ReadIntPtr(report, culprit).ToInt64();
            string text = Native.Text(IntPtr.Add(report, message));
            throw new CageformException(code, named > uint.MaxValue ? null : named.ToString(), text.Length > 0 ? text : null);
        }

        public void Dispose() { handle.Dispose(); }
    }

    /// An object of the library. It is freed before what it keeps alive: another object, or memory.
    public sealed class Handle : SafeHandle
    {
        Handle parent;
        AlignedBytes memory;

        Handle() : base(IntPtr.Zero, true) { }
        public override bool IsInvalid { get { return handle == IntPtr.Zero; } }

        internal Handle Keep(Handle other)
        {
            bool added = false;
            other.DangerousAddRef(ref added);
            parent = other;
            return this;
        }
        internal Handle Keep(AlignedBytes other)
        {
            memory = other;
            return this;
        }
        protected override bool ReleaseHandle()
        {
            bool freed = Native.cageform_free(handle) == 0;
            if (parent != null) parent.DangerousRelease();
            memory.Free();
            return freed;
        }
    }

    /// Memory aligned to 64 bytes, as the library requires.
    struct AlignedBytes
    {
        IntPtr memory;
        public readonly IntPtr Data;
        public readonly UIntPtr Size;

        public AlignedBytes(int size)
        {
            memory = Marshal.AllocHGlobal(size + 64);
            Data = new IntPtr((memory.ToInt64() + 63) / 64 * 64);
            Size = (UIntPtr)size;
        }
        public AlignedBytes(byte[] bytes) : this((bytes ?? throw new ArgumentNullException("bytes")).Length)
        {
            Marshal.Copy(bytes, 0, Data, bytes.Length);
        }
        public void Free()
        {
            Marshal.FreeHGlobal(memory);
            memory = IntPtr.Zero;
        }
    }

    /// An array that is pinned during a call.
    struct Pinned : IDisposable
    {
        GCHandle held;
        public readonly Native.Points View;

        public Pinned(float[] numbers, int dimension, int points, string name)
        {
            if (numbers == null) throw new ArgumentNullException(name);
            if (numbers.Length < (long)dimension * points)
                throw new ArgumentException(name + " has " + numbers.Length + (numbers.Length == 1 ? " number, " : " numbers, ") +
                                            (long)dimension * points + " are needed", name);
            held = GCHandle.Alloc(numbers, GCHandleType.Pinned);
            View = ViewOf(held.AddrOfPinnedObject(), dimension, points);
        }
        public IntPtr Address { get { return View.data; } }
        public static Native.Points ViewOf(IntPtr data, int dimension, int points)
        {
            return new Native.Points { data = data, count = (UIntPtr)points, bytes = (UIntPtr)(4UL * (ulong)dimension * (ulong)points),
                                       scalar = Native.Float, dimension = (uint)dimension };
        }
        public void Dispose()
        {
            if (held.IsAllocated) held.Free();
        }
    }

    static class Native
    {
        const string Library = "cageform"; // libcageform.so, libcageform.dylib, cageform.dll; linked statically: "__Internal"
        internal const uint Float = 0;
        internal const int ScalarDiffers = 1005, DimensionDiffers = 1006;

        // As in cageform.h; the test compares the offsets of members.
        [StructLayout(LayoutKind.Sequential)]
        internal struct Points // cageform_output is the same
        {
            internal IntPtr data;
            internal UIntPtr count, stride, bytes;
            internal uint scalar, dimension;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct FigureInfo
        {
            internal UIntPtr size, points, handles, vertices, clips, levels;
            internal uint scalar, dimension;
            internal int has_normals, has_tangents, has_labels;
            [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] internal double[] origin;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct ClipInfo
        {
            internal UIntPtr size, vertices;
            internal double begin, end;
            internal uint scalar, dimension;
            internal IntPtr name;
            internal UIntPtr name_length;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct SamplesInfo
        {
            internal UIntPtr size, handles;
            internal uint scalar, dimension;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct PinsOptions
        {
            internal UIntPtr size;
            internal double pin_weight;
            internal int hard;
            internal UIntPtr iterations;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct Fault
        {
            internal int status;
            internal uint a_is, b_is, reserved;
            internal UIntPtr a, b;
            internal IntPtr text;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct Report
        {
            internal UIntPtr size;
            internal int status;
            internal uint faults, warnings, reserved;
            internal UIntPtr culprit;
            internal Fault fault;
            internal double seconds;
            [MarshalAs(UnmanagedType.ByValArray, SizeConst = 256)] internal byte[] message;
            internal UIntPtr points, on_boundary, outside, faded, not_finite, unreached, not_restored;
            internal double partition_error, reproduction_error, least_weight, amplification;
            internal UIntPtr unknowns, memory;
            internal double grid_error, sufficient_accuracy;
            internal UIntPtr bytes, dense_bytes;
            internal double distance, mean_distance;
            internal UIntPtr vertices, components, tunnels;
            internal double margin, clearance, volume, tightest_volume, least_angle;
            internal UIntPtr samples, rotations;
            internal double miss, step, rigid_energy, least_stretch, largest_stretch;
            internal UIntPtr iterations, folded;
            internal int settled;
            internal double curve_error;
            internal UIntPtr bones, frame, beyond;
            internal double rms, max_distance, turn, mean_influences;
        }

        internal static UIntPtr SizeOf<T>() { return (UIntPtr)Marshal.SizeOf(typeof(T)); }
        internal static int OffsetOf(string member) { return Marshal.OffsetOf(typeof(Report), member).ToInt32(); }
        internal static UIntPtr Index(int number, string name)
        {
            if (number < 0) throw new ArgumentOutOfRangeException(name);
            return (UIntPtr)number;
        }
        internal static void Check(int code)
        {
            if (code != 0) throw new CageformException(code);
        }
        internal static string Text(IntPtr text) { return Marshal.PtrToStringAnsi(text); }

        [DllImport(Library)] internal static extern IntPtr cageform_status_text(int status);
        [DllImport(Library)] internal static extern IntPtr cageform_status_name(int status);
        [DllImport(Library)] internal static extern int cageform_free(IntPtr item);
        [DllImport(Library)] internal static extern int cageform_open(IntPtr data, UIntPtr bytes, IntPtr options, out Handle figure,
                                                                      out UIntPtr culprit);
        [DllImport(Library)] internal static extern int cageform_open_level(Handle figure, UIntPtr level, IntPtr options,
                                                                            out Handle opened);
        [DllImport(Library)] internal static extern int cageform_figure_describe(Handle figure, ref FigureInfo info);
        [DllImport(Library)] internal static extern int cageform_figure_rest(Handle figure, Points handles);
        [DllImport(Library)] internal static extern int cageform_figure_label(Handle figure, UIntPtr handle, out IntPtr text,
                                                                              out UIntPtr length);
        [DllImport(Library)] internal static extern int cageform_figure_find_handle(Handle figure, byte[] text, UIntPtr length,
                                                                                    out UIntPtr handle);
        [DllImport(Library)] internal static extern int cageform_clone(Handle figure, Points pose, Points points, IntPtr normals,
                                                                       IntPtr tangents, IntPtr running);
        [DllImport(Library)] internal static extern int cageform_clone(Handle figure, Points pose, Points points, ref Points normals,
                                                                       IntPtr tangents, IntPtr running);
        [DllImport(Library)] internal static extern int cageform_clone(Handle figure, Points pose, Points points, ref Points normals,
                                                                       ref Points tangents, IntPtr running);
        [DllImport(Library)] internal static extern int cageform_pose_handles(Handle figure, Points vertices, Points handles);
        [DllImport(Library)] internal static extern int cageform_figure_find_clip(Handle figure, byte[] name, UIntPtr length,
                                                                                  out UIntPtr clip);
        [DllImport(Library)] internal static extern int cageform_play(Handle figure, UIntPtr clip, IntPtr options, out Handle player);
        [DllImport(Library)] internal static extern int cageform_player_describe(Handle player, ref ClipInfo info);
        [DllImport(Library)] internal static extern int cageform_player_sample(Handle player, double time, Points pose);
        [DllImport(Library)] internal static extern int cageform_samples_open(IntPtr data, UIntPtr bytes, int skip_checksum,
                                                                              out Handle samples);
        [DllImport(Library)] internal static extern int cageform_samples_describe(Handle samples, ref SamplesInfo info);
        [DllImport(Library)] internal static extern int cageform_pins_create(Handle samples, ref PinsOptions options, out Handle pins);
        [DllImport(Library)] internal static extern int cageform_pins_set(Handle pins, Handle figure, int[] points, UIntPtr count,
                                                                          double[] weights, IntPtr report);
        [DllImport(Library)] internal static extern int cageform_pins_hold(Handle pins, int[] handles, UIntPtr count, IntPtr report);
        [DllImport(Library)] internal static extern int cageform_pins_solve(Handle pins, Points targets, Points pose, IntPtr report);
    }
}

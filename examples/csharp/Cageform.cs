// Packed figures in C#, for Unity and mono: open, clone, play. It calls the C interface of the shared library
// (include/cageform/c/cageform.h): put libcageform.so, libcageform.dylib or cageform.dll beside the program, in Unity into
// Assets/Plugins. No memory is allocated in a frame; arrays are pinned while a call lasts.
using System;
using System.Runtime.InteropServices;

namespace Cageform
{
    /// A status that is not ok; Code is its number, which never changes.
    public sealed class CageformException : Exception
    {
        public readonly int Code;
        public CageformException(int code) : base(Native.Text(code)) { Code = code; }
    }

    /// A packed figure: a file that bind_mesh or cageform_pack has written. Of float, in space.
    public sealed class Figure : IDisposable
    {
        IntPtr handle;
        readonly IntPtr file; // aligned to 64 bytes, inside of `memory`
        readonly IntPtr memory;
        readonly ulong[] sizes = new ulong[5];

        public int Points { get { return (int)sizes[0]; } }
        public int Handles { get { return (int)sizes[1]; } }
        /// Handles that are points of the cage: what clips and PoseHandles take.
        public int Vertices { get { return (int)sizes[2]; } }
        public int Clips { get { return (int)sizes[3]; } }
        public readonly bool HasNormals, HasTangents;

        /// Opens the bytes of a file, which are copied. Throws CageformException.
        public Figure(byte[] bytes)
        {
            if (bytes == null) throw new ArgumentNullException("bytes");
            memory = Marshal.AllocHGlobal(new IntPtr(bytes.LongLength + 64));
            file = new IntPtr((memory.ToInt64() + 63) / 64 * 64);
            Marshal.Copy(bytes, 0, file, bytes.Length);
            int code = Native.cageform_open(file, new UIntPtr((ulong)bytes.LongLength), IntPtr.Zero, out handle, IntPtr.Zero);
            var info = new Native.FigureInfo { size = (UIntPtr)Marshal.SizeOf(typeof(Native.FigureInfo)) };
            if (code == 0) code = Native.cageform_figure_describe(handle, ref info);
            if (code == 0 && (info.scalar != Native.Float || info.dimension != 3)) code = Native.ScalarDiffers;
            if (code != 0)
            {
                Dispose();
                throw new CageformException(code);
            }
            sizes[0] = (ulong)info.points;
            sizes[1] = (ulong)info.handles;
            sizes[2] = (ulong)info.vertices;
            sizes[3] = (ulong)info.clips;
            HasNormals = info.has_normals != 0;
            HasTangents = info.has_tangents != 0;
        }

        /// Writes the handles at rest, x y z each: a pose to start from.
        public void Rest(float[] pose)
        {
            using (var to = new Native.Pinned(pose, Handles, "pose"))
                Native.Check(Native.cageform_figure_rest(handle, to.Output()));
        }

        /// Moves the figure with a pose of all handles. Normals may be null.
        public void Clone(float[] pose, float[] points, float[] normals = null)
        {
            using (var from = new Native.Pinned(pose, Handles, "pose"))
            using (var to = new Native.Pinned(points, Points, "points"))
            {
                if (normals == null)
                {
                    Native.Check(Native.cageform_clone(handle, from.Input(), to.Output(), IntPtr.Zero, IntPtr.Zero, IntPtr.Zero));
                    return;
                }
                using (var turned = new Native.Pinned(normals, Points, "normals"))
                {
                    Native.Points output = turned.Output();
                    Native.Check(Native.cageform_clone_with_normals(handle, from.Input(), to.Output(), ref output, IntPtr.Zero,
                                                                    IntPtr.Zero));
                }
            }
        }

        /// Computes a pose of all handles from one of the cage's vertices, where Green coordinates have others too.
        public void PoseHandles(float[] vertices, float[] handles)
        {
            using (var from = new Native.Pinned(vertices, Vertices, "vertices"))
            using (var to = new Native.Pinned(handles, Handles, "handles"))
                Native.Check(Native.cageform_pose_handles(handle, from.Input(), to.Output()));
        }

        /// Plays a clip by its name; the player is used no longer than the figure.
        public Player Play(string name)
        {
            byte[] text = System.Text.Encoding.UTF8.GetBytes(name);
            UIntPtr clip;
            Native.Check(Native.cageform_figure_find_clip(handle, text, (UIntPtr)text.Length, out clip));
            if (clip == UIntPtr.Zero || (ulong)clip < (ulong)Clips) return new Player(handle, clip);
            throw new ArgumentException("the figure has no clip " + name);
        }

        public void Dispose()
        {
            Native.cageform_free(handle);
            handle = IntPtr.Zero;
            Marshal.FreeHGlobal(memory);
            GC.SuppressFinalize(this);
        }
    }

    /// Plays a clip: the motion of a cage's vertices.
    public sealed class Player : IDisposable
    {
        IntPtr handle;
        public readonly int Vertices;
        public readonly double Begin, End;

        internal Player(IntPtr figure, UIntPtr clip)
        {
            Native.Check(Native.cageform_play(figure, clip, IntPtr.Zero, out handle));
            var info = new Native.ClipInfo { size = (UIntPtr)Marshal.SizeOf(typeof(Native.ClipInfo)) };
            Native.Check(Native.cageform_player_describe(handle, ref info));
            Vertices = (int)(ulong)info.vertices;
            Begin = info.begin;
            End = info.end;
        }

        /// Writes the cage's vertices at a time in seconds, x y z each.
        public void Sample(double time, float[] vertices)
        {
            using (var to = new Native.Pinned(vertices, Vertices, "vertices"))
                Native.Check(Native.cageform_player_sample(handle, time, to.Output()));
        }

        public void Dispose()
        {
            Native.cageform_free(handle);
            handle = IntPtr.Zero;
        }
    }

    static class Native
    {
        const string Library = "cageform";
        internal const uint Float = 0;
        internal const int ScalarDiffers = 1005;

        [StructLayout(LayoutKind.Sequential)]
        internal struct Points // cageform_points and cageform_output
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

        /// An array that stays in its place while a call lasts.
        internal struct Pinned : IDisposable
        {
            GCHandle held;
            readonly int count;

            internal Pinned(float[] numbers, int points, string name)
            {
                if (numbers == null) throw new ArgumentNullException(name);
                if (numbers.Length < 3 * points)
                    throw new ArgumentException(name + " has " + numbers.Length + " numbers, " + 3 * points + " are needed");
                held = GCHandle.Alloc(numbers, GCHandleType.Pinned);
                count = points;
            }
            internal Points Output()
            {
                return new Points { data = held.AddrOfPinnedObject(), count = (UIntPtr)count, bytes = (UIntPtr)(12L * count),
                                    scalar = Float, dimension = 3 };
            }
            internal Points Input() { return Output(); }
            public void Dispose() { held.Free(); }
        }

        internal static void Check(int code)
        {
            if (code != 0) throw new CageformException(code);
        }
        internal static string Text(int code) { return Marshal.PtrToStringAnsi(cageform_status_text(code)); }

        [DllImport(Library)] static extern IntPtr cageform_status_text(int status);
        [DllImport(Library)] internal static extern int cageform_free(IntPtr item);
        [DllImport(Library)] internal static extern int cageform_open(IntPtr data, UIntPtr bytes, IntPtr options, out IntPtr figure,
                                                                      IntPtr culprit);
        [DllImport(Library)] internal static extern int cageform_figure_describe(IntPtr figure, ref FigureInfo info);
        [DllImport(Library)] internal static extern int cageform_figure_rest(IntPtr figure, Points handles);
        [DllImport(Library)] internal static extern int cageform_clone(IntPtr figure, Points pose, Points points, IntPtr normals,
                                                                       IntPtr tangents, IntPtr running);
        [DllImport(Library, EntryPoint = "cageform_clone")]
        internal static extern int cageform_clone_with_normals(IntPtr figure, Points pose, Points points, ref Points normals,
                                                               IntPtr tangents, IntPtr running);
        [DllImport(Library)] internal static extern int cageform_pose_handles(IntPtr figure, Points vertices, Points handles);
        [DllImport(Library)] internal static extern int cageform_figure_find_clip(IntPtr figure, byte[] name, UIntPtr length,
                                                                                  out UIntPtr clip);
        [DllImport(Library)] internal static extern int cageform_play(IntPtr figure, UIntPtr clip, IntPtr options,
                                                                      out IntPtr player);
        [DllImport(Library)] internal static extern int cageform_player_describe(IntPtr player, ref ClipInfo info);
        [DllImport(Library)] internal static extern int cageform_player_sample(IntPtr player, double time, Points pose);
    }
}

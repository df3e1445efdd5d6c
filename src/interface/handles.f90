!> The handles: objects that callers in C and Fortran 77 hold by a number.
!>
!> A handle is a positive integer that is never given out twice in 131071 objects of one slot, so that
!> one that was freed, or never made, is recognised and nothing is read through it. Objects are not
!> changed once they are stored, but a live estimate by its one thread. To use one takes no lock: `acquire`
!> counts the user in, `release` out, and `remove` waits until nobody is in.
module gracecg_interface_handles
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_base_kinds, only: i8
    use gracecg_interface_items, only: items_t
    implicit none
    private
    public :: object_t, no_object_t, store, acquire, release, remove, live_objects, MAX_OBJECTS

    integer, parameter :: MAX_OBJECTS = 16384       !! That may be alive at once; a power of two
    integer, parameter :: LAST_GENERATION = huge(0)/MAX_OBJECTS

    !> What a handle stands for.
    type, abstract :: object_t
    contains
        procedure :: tell => tell_nothing               !! Puts its items, of which one is wanted
    end type object_t

    !> Stands for the object of a handle that is none.
    type, extends(object_t) :: no_object_t
    end type no_object_t

    type :: slot_t
        integer :: handle = 0                           !! Of the object; 0: none that may be used
        integer :: users = 0                            !! That are in, or are just being turned away
        integer :: generation = 0                       !! Objects that were here
        logical :: occupied = .false.                   !! Until the object is gone from memory
        class(object_t), pointer :: object              !! Defined while occupied
    end type slot_t

    type(slot_t), save, target :: slots(0:MAX_OBJECTS - 1)
    type(no_object_t), save, target :: nothing
    integer, save :: last_slot = MAX_OBJECTS - 1        !! That was given out
    integer, save :: alive = 0                          !! Objects

    interface
        !> The thread rests for some microseconds.
        integer(c_int) function pause_for(microseconds) bind(c, name='usleep')
            import :: c_int
            integer(c_int), value :: microseconds   !! Less than a million
        end function pause_for
    end interface

contains

    subroutine tell_nothing(self, items)
        class(object_t), intent(in) :: self
        type(items_t), intent(inout) :: items

        associate (without => self, any => items)   ! as a model: it has none
        end associate
    end subroutine tell_nothing

    !> Takes an object over and gives its handle: 0 when there is no room, and the object is then still
    !> the caller's.
    subroutine store(object, handle)
        class(object_t), pointer, intent(in) :: object
        integer, intent(out) :: handle  !! Positive; 0 when there is no room

        integer :: i, place

        handle = 0
        !$omp critical (gracecg_handle_table)
        do i = 1, MAX_OBJECTS
            place = modulo(last_slot + i, MAX_OBJECTS)
            if (slots(place)%occupied) cycle
            last_slot = place
            alive = alive + 1
            associate (slot => slots(place))
                slot%occupied = .true.
                slot%object => object
                slot%generation = modulo(slot%generation, LAST_GENERATION) + 1
                handle = (slot%generation - 1)*MAX_OBJECTS + place + 1
                !$omp atomic write seq_cst
                slot%handle = handle
            end associate
            exit
        end do
        !$omp end critical (gracecg_handle_table)
    end subroutine store

    !> The object of a handle, in use until `release`; of type `no_object_t` when there is none.
    subroutine acquire(handle, object)
        integer(i8), intent(in) :: handle   !! Any number
        class(object_t), pointer, intent(out) :: object

        integer :: place, present_handle

        object => nothing
        if (handle < 1 .or. handle > huge(0)) return
        place = place_of(handle)
        !$omp atomic update seq_cst
        slots(place)%users = slots(place)%users + 1
        !$omp atomic read seq_cst
        present_handle = slots(place)%handle
        if (present_handle == handle) then
            object => slots(place)%object
        else
            call leave(place)
        end if
    end subroutine acquire

    !> Ends the use of an object that `acquire` gave.
    subroutine release(handle, object)
        integer(i8), intent(in) :: handle   !! As given to `acquire`
        class(object_t), pointer, intent(inout) :: object

        if (associated(object)) then
            select type (object)
            type is (no_object_t)
            class default
                call leave(place_of(handle))
            end select
        end if
        object => null()
    end subroutine release

    !> Removes an object from memory when all who use it have released it. False when the handle is of
    !> none, or another thread is removing the object.
    logical function remove(handle) result(removed)
        integer(i8), intent(in) :: handle   !! Any number

        class(object_t), pointer :: object
        integer :: place, users
        integer(c_int) :: ignored

        removed = .false.
        if (handle < 1 .or. handle > huge(0)) return
        place = place_of(handle)
        !$omp critical (gracecg_handle_table)
        if (slots(place)%handle == handle) then
            !$omp atomic write seq_cst
            slots(place)%handle = 0
            removed = .true.
        end if
        !$omp end critical (gracecg_handle_table)
        if (.not. removed) return
        do
            !$omp atomic read seq_cst
            users = slots(place)%users
            if (users == 0) exit
            ignored = pause_for(100_c_int)
        end do
        object => slots(place)%object
        deallocate (object)
        !$omp critical (gracecg_handle_table)
        slots(place)%occupied = .false.
        alive = alive - 1
        !$omp end critical (gracecg_handle_table)
    end function remove

    !> How many objects are alive.
    integer function live_objects() result(n)
        !$omp critical (gracecg_handle_table)
        n = alive
        !$omp end critical (gracecg_handle_table)
    end function live_objects

    subroutine leave(place)
        integer, intent(in) :: place

        !$omp atomic update seq_cst
        slots(place)%users = slots(place)%users - 1
    end subroutine leave

    pure integer function place_of(handle)
        integer(i8), intent(in) :: handle       !! 1 to huge(0)

        place_of = int(modulo(handle - 1, int(MAX_OBJECTS, i8)))
    end function place_of
end module gracecg_interface_handles

!> A folder of Level-1 files being written: product after product, record after record. After a failure, which is kept,
!> nothing more is done.
!>
!>     call folder%begin('SCA1B', records, first, last)
!>     call folder%tag(time)                       ! for each record
!>     call folder%put('quatangle', values)
!>     call folder%record()
!>     call folder%finish()
module gracecg_level1_simulated_folder
    use, intrinsic :: iso_fortran_env, only: real32
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: string_t, append
    use gracecg_files_file, only: remove_file
    use gracecg_level1_header, only: level1_header_t
    use gracecg_level1_products, only: level1_layout_t, level1_layout, KIND_F4
    use gracecg_level1_time, only: gps_date_text
    use gracecg_level1_writer, only: level1_writer_t
    implicit none
    private
    public :: level1_folder_t

    !> The folder, and the file of it that is being written.
    type :: level1_folder_t
        character(:), allocatable :: name   !! Its path
        character(1) :: satellite = ''      !! A, B, C or D
        logical :: grace_fo = .true.        !! Satellite C or D
        logical :: binary = .false.         !! GRACE's binary records, where there are such
        integer(i8) :: epoch = 0            !! GPS s past 2000-01-01 12:00: time 0
        type(string_t), allocatable :: written(:)   !! Names of the files, in their order
        type(error_t), allocatable :: failure       !! The first thing that went wrong
        type(level1_layout_t) :: layout             !! Of the product that is written
        real(dp), allocatable :: values(:)          !! Of its next record, by field
        type(level1_writer_t), private :: writer
    contains
        procedure :: begin          !! The file of a product
        procedure :: tag            !! Time tag of the next record
        procedure :: put            !! Values of the next record
        procedure :: record         !! Writes the record
        procedure :: finish         !! The file is complete
        procedure :: path_of        !! Path of a file
        procedure :: remove         !! Leaves no file
    end type level1_folder_t

contains

    !> Begins the file of a product.
    subroutine begin(self, product, records, first, last)
        class(level1_folder_t), intent(inout) :: self
        character(5), intent(in) :: product    !! Such as ACC1A
        integer, intent(in) :: records    !! How many will follow
        real(dp), intent(in) :: first, last     !! Tags, s from the epoch

        type(level1_header_t) :: header
        character(26) :: date
        character(4) :: ending
        logical :: binary

        if (allocated(self%failure)) return
        call level1_layout(product, self%grace_fo, self%layout, self%failure)
        if (allocated(self%failure)) return
        binary = self%binary .and. self%layout%has_binary
        ending = merge('.txt', '.asc', self%grace_fo)
        if (binary) ending = '.dat'
        header%satellite = self%satellite
        header%records = records
        header%first_time = real(self%epoch, dp) + first
        header%last_time = real(self%epoch, dp) + last
        date = gps_date_text(self%epoch, 0.0_dp)
        if (allocated(self%values)) deallocate (self%values)
        allocate (self%values(size(self%layout%fields)), source=0.0_dp)
        if (self%layout%id > 0) self%values(self%layout%id) = iachar(self%satellite)
        if (self%layout%time_ref > 0) self%values(self%layout%time_ref) = iachar(merge('R', 'G', product(5:5) == 'A'))
        associate (name => product//'_'//date(:10)//'_'//self%satellite//'_'//merge('04', '02', self%grace_fo)//ending)
            call self%writer%open(self%path_of(name), self%layout, binary, header, self%failure)
            if (.not. allocated(self%failure)) call append(self%written, name)
        end associate
    end subroutine begin

    !> A time tag as seconds and microseconds; and as it is then.
    subroutine tag(self, time, rounded)
        class(level1_folder_t), intent(inout) :: self
        real(dp), intent(in) :: time                    !! s from the epoch
        real(dp), intent(out), optional :: rounded      !! s from the epoch

        integer(i8) :: ticks

        ticks = nint(time*1e6_dp, i8)
        if (present(rounded)) rounded = real(ticks, dp)/1e6_dp
        if (allocated(self%failure)) return
        self%values(1) = real(self%epoch + floor(real(ticks, dp)/1e6_dp, i8), dp)
        if (self%layout%fraction > 0) self%values(self%layout%fraction) = real(modulo(ticks, 1000000_i8), dp)
    end subroutine tag

    !> Puts values in a row of fields, the first by its name. Of single precision is what binary has so.
    subroutine put(self, name, values)
        class(level1_folder_t), intent(inout) :: self
        character(*), intent(in) :: name        !! Of the first field
        real(dp), intent(in) :: values(:)       !! In the units of the product

        integer :: first, i

        if (allocated(self%failure)) return
        first = self%layout%field_of(name) - 1
        do i = 1, size(values)
            self%values(first + i) = values(i)
            if (self%layout%fields(first + i)%kind == KIND_F4) self%values(first + i) = real(real(values(i), real32), dp)
        end do
    end subroutine put

    subroutine record(self)
        class(level1_folder_t), intent(inout) :: self

        if (.not. allocated(self%failure)) call self%writer%record(self%values)
    end subroutine record

    subroutine finish(self)
        class(level1_folder_t), intent(inout) :: self

        if (.not. allocated(self%failure)) call self%writer%commit(self%failure)
    end subroutine finish

    pure function path_of(self, name) result(path)
        class(level1_folder_t), intent(in) :: self
        character(*), intent(in) :: name        !! Of the file
        character(len(self%name) + 1 + len(name)) :: path

        path = self%name//'/'//name
    end function path_of

    !> Removes the files that were written.
    subroutine remove(self)
        class(level1_folder_t), intent(inout) :: self

        integer :: i

        do i = 1, size(self%written)
            call remove_file(self%path_of(self%written(i)%text))
        end do
        self%written = self%written(:0)
    end subroutine remove
end module gracecg_level1_simulated_folder

!> Shards by the variables of launchers and job arrays.
module test_launcher
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
    use gracecg_base_text, only: integer_text
    use gracecg_cli_launcher, only: find_place
    use fixture, only: check
    use testdrive, only: new_unittest, unittest_type, error_type
    implicit none
    private
    public :: collect_launcher

    integer, parameter :: W = 24
    !> Everything that is looked at
    character(W), parameter :: NAMES(14) = [character(W) :: 'OMPI_COMM_WORLD_RANK', 'OMPI_COMM_WORLD_SIZE', 'PMI_RANK', &
        'PMI_SIZE', 'SLURM_PROCID', 'SLURM_STEP_NUM_TASKS', 'SLURM_ARRAY_TASK_ID', 'SLURM_ARRAY_TASK_MIN', &
        'SLURM_ARRAY_TASK_MAX', 'SLURM_ARRAY_TASK_STEP', 'SGE_TASK_ID', 'SGE_TASK_FIRST', 'SGE_TASK_LAST', &
        'SGE_TASK_STEPSIZE']

    interface
        integer(c_int) function c_setenv(name, value, overwrite) bind(c, name='setenv')
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: name(*), value(*)
            integer(c_int), value :: overwrite
        end function c_setenv

        integer(c_int) function c_unsetenv(name) bind(c, name='unsetenv')
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: name(*)
        end function c_unsetenv
    end interface

contains

    !> The tests of this suite.
    subroutine collect_launcher(tests)
        type(unittest_type), allocatable, intent(out) :: tests(:)

        tests = [new_unittest('launchers-and-arrays', test_places), new_unittest('contradictions', test_problems)]
    end subroutine collect_launcher

    !> The place that variables NAME=VALUE, blanks between them, give; all others are not set. '' when there is a problem.
    function place_of(variables) result(text)
        character(*), intent(in) :: variables
        character(:), allocatable :: text

        character(:), allocatable :: problem, rest
        integer(c_int) :: ignored
        integer :: i, place, places, equals, blank

        do i = 1, size(NAMES)
            ignored = c_unsetenv(trim(NAMES(i))//c_null_char)
        end do
        rest = variables
        do while (rest /= '')
            equals = index(rest, '=')
            blank = index(rest//' ', ' ')
            ignored = c_setenv(rest(:equals - 1)//c_null_char, rest(equals + 1:blank - 1)//c_null_char, 1_c_int)
            rest = adjustl(rest(blank:))
        end do
        call find_place(place, places, problem)
        text = ''
        if (.not. allocated(problem)) text = integer_text(place)//'/'//integer_text(places)
        do i = 1, size(NAMES)
            ignored = c_unsetenv(trim(NAMES(i))//c_null_char)
        end do
    end function place_of

    subroutine test_places(error)
        type(error_type), allocatable, intent(out) :: error

        character(*), parameter :: ARRAY = 'SLURM_ARRAY_TASK_ID=7 SLURM_ARRAY_TASK_MIN=3 SLURM_ARRAY_TASK_MAX=9 '// &
            'SLURM_ARRAY_TASK_STEP=2'

        call check(error, place_of('OMPI_COMM_WORLD_RANK=0 OMPI_COMM_WORLD_SIZE=4'), '1/4')
        call check(error, place_of('PMI_RANK=3 PMI_SIZE=4'), '4/4')
        call check(error, place_of('SLURM_PROCID=1 SLURM_STEP_NUM_TASKS=20'), '2/20')
        call check(error, place_of(ARRAY), '3/4')
        call check(error, place_of('SGE_TASK_ID=5 SGE_TASK_FIRST=1 SGE_TASK_LAST=20 SGE_TASK_STEPSIZE=1'), '5/20')
        ! An array of jobs with two processes each
        call check(error, place_of(ARRAY//' SLURM_PROCID=1 SLURM_STEP_NUM_TASKS=2'), '6/8')
        ! A batch script that Slurm gave several tasks is one process: srun has not started them
        call check(error, place_of('SLURM_PROCID=0 SLURM_NTASKS=8'), '')
        ! SGE outside an array
        call check(error, place_of('SGE_TASK_ID=undefined PMI_RANK=1 PMI_SIZE=2'), '2/2')
    end subroutine test_places

    subroutine test_problems(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, place_of(''), '')
        call check(error, place_of('PMI_RANK=4 PMI_SIZE=4'), '')
        call check(error, place_of('SGE_TASK_ID=5 SGE_TASK_FIRST=6 SGE_TASK_LAST=20'), '')
        call check(error, place_of('SGE_TASK_ID=5 SGE_TASK_LAST=20'), '')
        call check(error, place_of('SGE_TASK_ID=5 PMI_RANK=1 PMI_SIZE=2'), '')
    end subroutine test_problems
end module test_launcher

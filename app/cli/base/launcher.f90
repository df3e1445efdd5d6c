!> Which of several processes this one is, as launchers and job arrays say by environment variables.
!>
!> A job array and a launcher may stand one in the other: an array of jobs, each with several processes, counts them all.
module gracecg_cli_launcher
    use gracecg_base_text, only: parse_integer
    implicit none
    private
    public :: find_place

    !> Variables of the number of a process, of the first, of the last, and of the step between numbers. Launchers, whose
    !> numbers begin with 0, have that of how many there are in place of the last.
    character(22), parameter :: LAUNCHERS(4, 3) = reshape([character(22) :: &
        'OMPI_COMM_WORLD_RANK', '', 'OMPI_COMM_WORLD_SIZE', '', 'PMI_RANK', '', 'PMI_SIZE', '', &
        'SLURM_PROCID', '', 'SLURM_STEP_NUM_TASKS', ''], [4, 3])
    character(22), parameter :: ARRAYS(4, 2) = reshape([character(22) :: &
        'SLURM_ARRAY_TASK_ID', 'SLURM_ARRAY_TASK_MIN', 'SLURM_ARRAY_TASK_MAX', 'SLURM_ARRAY_TASK_STEP', &
        'SGE_TASK_ID', 'SGE_TASK_FIRST', 'SGE_TASK_LAST', 'SGE_TASK_STEPSIZE'], [4, 2])

contains

    !> The number of this process, from 1 on, and how many there are. `problem` says why they cannot be found.
    subroutine find_place(place, places, problem)
        integer, intent(out) :: place, places   !! Number of this process, number of all
        character(:), allocatable, intent(out) :: problem   !! Not allocated: all is well

        integer :: job, jobs, rank, ranks

        call look(ARRAYS, job, jobs, problem)
        call look(LAUNCHERS, rank, ranks, problem)
        if (jobs + ranks == 0 .and. .not. allocated(problem)) problem = 'no variable of the environment tells of a '// &
            'launcher or a job array; known are job arrays of Slurm and SGE, and processes started by srun, Open MPI''s or '// &
            'MPICH''s mpirun'
        place = job*max(ranks, 1) + rank + 1
        places = max(jobs, 1)*max(ranks, 1)
    end subroutine find_place

    !> Place by the first row of a table whose variables are there, from 0 on; places = 0: there is none.
    subroutine look(table, place, places, problem)
        character(*), intent(in) :: table(:, :)
        integer, intent(out) :: place, places
        character(:), allocatable, intent(inout) :: problem

        integer :: i, index, first, last, step
        logical :: found(4)

        place = 0
        places = 0
        do i = 1, size(table, 2)
            call get_number(table(1, i), index, found(1))
            call get_number(table(2, i), first, found(2))
            call get_number(table(3, i), last, found(3))
            call get_number(table(4, i), step, found(4))
            if (table(2, i) == '') then
                found(2) = .true.
                last = last - 1
                if (.not. found(3)) cycle
            end if
            if (.not. found(1)) cycle
            if (.not. found(4)) step = 1
            if (.not. all(found(2:3)) .or. step < 1 .or. index < first .or. index > last) then
                problem = 'the variable '//trim(table(1, i))//' does not agree with '//trim(table(3, i))
                return
            end if
            place = (index - first)/step
            places = (last - first)/step + 1
            return
        end do
    end subroutine look

    !> A whole number of the environment; 0 where there is none.
    subroutine get_number(name, number, found)
        character(*), intent(in) :: name        !! Empty: none
        integer, intent(out) :: number
        logical, intent(out) :: found           !! There is such a variable, with a number in it

        character(32) :: text
        integer :: status

        number = 0
        found = .false.
        if (name == '') return
        call get_environment_variable(trim(name), text, status=status)
        if (status == 0) call parse_integer(trim(text), number, found)
    end subroutine get_number
end module gracecg_cli_launcher
